"""The command line: ``roughcontact paper``, ``solve`` and ``stability``."""

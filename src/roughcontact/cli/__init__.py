"""The command line: ``roughcontact paper``, ``roughcontact solve`` and ``roughcontact report``."""

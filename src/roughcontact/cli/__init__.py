"""The command line: ``roughcontact paper`` and ``roughcontact solve``."""

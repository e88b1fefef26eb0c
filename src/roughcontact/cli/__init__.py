"""The command line: ``roughcontact paper``, ``solve``, ``report``, ``run`` and ``stability``."""

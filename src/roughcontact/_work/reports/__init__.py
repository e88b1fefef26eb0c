"""Error against run time, and stability of an answer."""

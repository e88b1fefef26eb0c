"""Many contacts on one grid that are solved at once."""

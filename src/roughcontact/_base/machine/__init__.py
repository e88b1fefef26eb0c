"""Memory and threads of the machine."""

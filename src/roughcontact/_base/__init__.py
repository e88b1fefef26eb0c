"""What knows nothing of contacts: names of parts, numbers for people, checks, the machine, files."""

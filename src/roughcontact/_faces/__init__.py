"""Figures, pages and the command line."""

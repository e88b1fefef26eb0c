"""Partial slip under a tangential force."""

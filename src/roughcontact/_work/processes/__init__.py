"""Repeated loading that changes the surfaces."""

"""Displacement, pressure, problem and solution."""

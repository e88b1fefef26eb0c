"""Responses to small changes: stiffness, conductance, gradients."""

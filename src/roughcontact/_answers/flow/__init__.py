"""Flow through the gap, leakage and percolation, and of the heat of sliding."""

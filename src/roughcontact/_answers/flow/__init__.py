"""Flow through the gap: leakage and percolation."""

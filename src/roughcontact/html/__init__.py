"""A solution as one page that opens in any browser."""

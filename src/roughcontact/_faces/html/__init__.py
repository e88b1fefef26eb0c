"""A result as one page that opens in any browser, and as a table in a notebook."""

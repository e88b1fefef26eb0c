"""The page in the browser, on this machine."""

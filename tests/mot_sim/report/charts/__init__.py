"""Charts and their figures."""

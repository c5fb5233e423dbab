"""Live traffic, beside the folder it tests."""

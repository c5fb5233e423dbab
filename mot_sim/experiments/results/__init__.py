"""`result.json`: what a command found."""

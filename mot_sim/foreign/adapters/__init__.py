"""Programs that run guests in their own environments: `run.py`, and a file for each package."""

"""Runs of a tracker over drives, their folders, and their scores."""

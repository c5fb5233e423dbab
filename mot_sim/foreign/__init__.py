"""Trackers that are not ours: how they are called, and the processes that they run in."""

"""Tests of other people's trackers: protocol, processes, environments."""

"""Measurements: quality on KITTI, speed, and what other programs say. Run from the root."""

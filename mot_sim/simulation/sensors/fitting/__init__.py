"""Noise profiles fitted to real detections."""

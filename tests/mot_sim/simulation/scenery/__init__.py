"""Tests of the world around the cars."""

"""Stress suites with bounds, and the search for the level that breaks a tracker."""

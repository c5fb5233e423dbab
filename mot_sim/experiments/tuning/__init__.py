"""Weights of costs by cross-validation over labelled drives."""

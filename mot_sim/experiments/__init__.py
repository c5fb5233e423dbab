"""Controlled experiments: sweeps, stress suites, tuning, the paper's tables, guests."""

"""Tests of mot_sim.truth."""

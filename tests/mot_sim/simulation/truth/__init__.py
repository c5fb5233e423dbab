"""Tests of mot_sim.simulation.truth."""

"""One file = one scene: what can be run, found by name through `mot_sim.simulation.registry`."""

"""The simulation: traffic, cars, scenery, renderers, ground truth, sensors, episodes."""

"""What the Gymnasium environments are made of: runs, observations, running counts, wrappers."""

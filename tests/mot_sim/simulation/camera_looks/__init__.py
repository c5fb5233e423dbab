"""Kernels of the simulator beside the same in plain NumPy."""

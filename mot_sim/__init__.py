"""The testbed: it makes worlds, reads KITTI, adds noise, scores, sweeps and reports."""

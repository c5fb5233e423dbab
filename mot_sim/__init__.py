"""The testbed: it makes worlds, reads KITTI, adds noise, scores, sweeps and reports.

Importing it registers the Gymnasium ids, so that `gym.make("mot_sim/Crossing-v0")` finds them.
"""

from mot_sim.envs.registration import register_environments

register_environments()

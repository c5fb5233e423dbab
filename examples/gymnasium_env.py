"""Scenes as Gymnasium environments: to watch, to drive in, and a game of data association.

Importing mot_sim registers one id per scene, and mot_sim/Association-v0.
"""

import gymnasium as gym

import mot_sim  # noqa: F401  (registers the ids)
from mot_sim.envs.association_experts import hungarian_policy
from mot_sim.envs.wrappers import Scored, TrackObservation

# 1. Watch recorded traffic: the observation holds detections and, by the wrapper, tracks.
env = Scored(TrackObservation(gym.make("mot_sim/Crossing-v0", image=False, frames=20)))
observation, info = env.reset(seed=3)
print("observation:", ", ".join(observation))
over = False
while not over:
    observation, reward, terminated, truncated, info = env.step(0)
    over = terminated or truncated
print(f"watched: {int(observation['tracks']['mask'].sum())} tracks at the end,", end=" ")
print(f"MOTA {100 * info['scores']['MOTA']:.1f}, HOTA {100 * info['final_scores']['HOTA']:.1f}")
env.close()

# 2. Drive: actions are lane_left, idle, lane_right, faster, slower, autopilot.
env = gym.make("mot_sim/Highway-v0", actions="meta", image=False, frames=30)
observation, info = env.reset(seed=3)
total = 0.0
for step in range(20):  # to the left lane, then as the autopilot likes
    observation, reward, terminated, truncated, info = env.step(0 if step == 0 else 5)
    total += reward
    if terminated or truncated:
        break
print(f"driven: {info['frame']} frames, crashed: {info['crashed']},", end=" ")
print(f"mean reward {total / info['frame']:.2f}")
env.close()

# 3. Decide which detection belongs to which track; the return of an episode is its MOTA.
env = gym.make("mot_sim/Association-v0", scene="crossing", frames=20, pool=1)
observation, info = env.reset(seed=3)
total, over = 0.0, False
while not over:
    observation, reward, over, _, info = env.step(hungarian_policy(observation))
    total += reward
print(f"association: return {total:.3f}, {info['IDSW']} identity switches")
env.close()

# Printed:
# observation: boxes, scores, mask, odometry, time, tracks
# watched: 6 tracks at the end, MOTA 95.4, HOTA 85.2
# driven: 20 frames, crashed: False, mean reward 0.62
# association: return 0.966, 0 identity switches

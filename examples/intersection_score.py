"""Make an intersection with exact ground truth, and score two trackers on it.

An episode is one run of a scene: frames for a tracker, and the truth apart from them. The same
seed gives the same episode. Nothing is downloaded.
"""

from mot_sim import Tracker, evaluate_sequence, find_scene, record, track_sequence

scene = find_scene("intersection", frames=25, weather="rain")
episode = record(scene, seed=1)
cars = len(set(episode.truth.ids.tolist()))
print(f"{len(episode)} frames, {len(episode.truth)} labels of {cars} cars")

for name, tracker in {
    "default": Tracker.default(episode.camera),
    "paper": Tracker.paper(episode.camera),
}.items():
    tracks, counts = track_sequence(tracker, episode)
    scores = evaluate_sequence(episode.truth, tracks, len(episode))
    print(
        f"{name}: HOTA {100 * scores['HOTA']:.1f}, MOTA {100 * scores['MOTA']:.1f}, "
        f"{scores['IDSW']:.0f} identity switches"
    )

# Printed:
# 25 frames, 947 labels of 18 cars
# default: HOTA 89.4, MOTA 91.7, 0 identity switches
# paper: HOTA 89.2, MOTA 92.4, 0 identity switches

"""A matching cost of your own, alone and beside the image overlap.

A cost is a frozen dataclass that is called with the pairs inside the search areas and gives one
number in [0, 1] per pair: small for the same object, NaN where it cannot be measured.
"""

from dataclasses import dataclass

import numpy as np

from mot_sim import Tracker, evaluate_sequence, find_scene, record, track_sequence
from tracker.costs import GatedPairs, ImageOverlap


@dataclass(frozen=True)
class SameHeight:
    """1 - lower / higher of the two boxes of a pair."""

    def __call__(self, pairs: GatedPairs) -> np.ndarray:
        rows, columns = pairs.pairs
        expected, observed = pairs.expected.boxes[rows], pairs.observed.boxes[columns]
        one, other = expected[:, 3] - expected[:, 1], observed[:, 3] - observed[:, 1]
        return 1.0 - np.minimum(one, other) / np.maximum(one, other)


episode = record(find_scene("intersection", frames=25), seed=2)
for name, costs in {
    "same height": ((1.0, SameHeight()),),
    "image overlap": ((1.0, ImageOverlap(0.1)),),
    "0.8 image overlap + 0.2 same height": ((0.8, ImageOverlap(0.1)), (0.2, SameHeight())),
}.items():
    tracks, counts = track_sequence(Tracker.default(episode.camera, costs), episode)
    scores = evaluate_sequence(episode.truth, tracks, len(episode))
    print(f"{name}: HOTA {100 * scores['HOTA']:.1f}, {scores['IDSW']:.0f} identity switches")

# Printed:
# same height: HOTA 83.3, 9 identity switches
# image overlap: HOTA 87.7, 0 identity switches
# 0.8 image overlap + 0.2 same height: HOTA 87.7, 0 identity switches

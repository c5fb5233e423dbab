"""What a detector's scores are worth, told by how its boxes fare: no threshold fits all detectors.

Scores are taken as the probabilities that they are meant to be, until the boxes contradict it. A
box is confirmed when the next frame has one in its place. Scores that tell confirmed boxes from
others no better than chance carry no information: all boxes count the same. Where they do tell,
but confirmed boxes hardly reach the scores that begin a track, their order is kept and their
scale is that of a well calibrated detector.
"""

from bisect import bisect
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadConfig
from tracker.geometry import box_iou
from tracker.types import Detections

# Two boxes in neighbouring frames that overlap so much are of one thing.
CONFIRMING_IOU = 0.3
# The judgement is made anew whenever so many more boxes were watched; then never again.
JUDGED_AT = (12, 24, 48, 96, 192, 384, 768)
# Boxes are told apart at these times, and whenever more frames than these are remembered.
MOST_FRAMES = 64
# Logits are smaller, percentages larger.
LARGEST_LOGIT = 20.0
# What the judgement `ranked` gives to scores at these shares of the confirmed boxes: nearly all
# begin tracks, as with calibrated detectors on KITTI.
SHARES = np.array([0.0, 0.05, 0.1, 0.2, 0.4, 1.0])
PROBABILITIES = np.array([0.5, 0.8, 0.85, 0.9, 0.95, 1.0])


class ScoreMemory(NamedTuple):
    """What a tracker remembers of its detector's scores; never modified."""

    low: float = np.inf
    """The lowest score so far."""
    high: float = -np.inf
    """The highest score so far."""
    frames: tuple[tuple[Float[Array, "_ 4"], Float[Array, " _"]], ...] = ()
    """Boxes (pixels) and scores of the last frames, as the detector gave them; all but the last
    are watched, but not yet told apart."""
    watched: int = 0
    """How many boxes had a next frame to be confirmed by."""
    confirmed: Float[Array, " c"] = np.zeros(0)
    """Scores of watched boxes that the next frame confirmed."""
    vanished: Float[Array, " v"] = np.zeros(0)
    """Scores of watched boxes that it did not confirm."""
    judgement: str = ""
    """Empty: probabilities, or what a known scale says; `even`: worth nothing; `ranked`."""
    landmarks: Float[Array, " q"] = np.zeros(0)
    """Scores at SHARES of the confirmed boxes, ascending, of the judgement `ranked`."""

    @property
    def says_nothing(self) -> bool:
        """Whether scores were found to tell nothing of their boxes."""
        return self.judgement == "even"

    def told_apart(self) -> "ScoreMemory":
        """With all watched boxes among the confirmed or the vanished ones."""
        boxes = np.concatenate([boxes for boxes, _ in self.frames])
        counts = np.array([len(boxes) for boxes, _ in self.frames])
        # Every box with each of those of its next frame.
        others = np.repeat(counts[1:], counts[:-1])
        first = np.repeat(np.cumsum(counts)[:-1], counts[:-1]) - (np.cumsum(others) - others)
        box = np.repeat(np.arange(len(others)), others)
        other = np.arange(len(box)) + np.repeat(first, others)
        is_confirmed = np.zeros(len(others), bool)
        is_confirmed[box[box_iou(boxes[box], boxes[other]) >= CONFIRMING_IOU]] = True
        scores = np.concatenate([np.zeros(0), *(scores for _, scores in self.frames[:-1])])
        return self._replace(
            frames=self.frames[-1:],
            confirmed=np.concatenate((self.confirmed, scores[is_confirmed])),
            vanished=np.concatenate((self.vanished, scores[~is_confirmed])),
        )


@dataclass(frozen=True)
class ScoreScale:
    """Gives detections scores that are probabilities, whatever scale the detector's have."""

    strong: float = 0.8
    """The probability that begins a track, in (0, 1]; what boxes get whose scores say nothing."""
    least_strong: float = 0.25
    """The share of confirmed boxes, in [0, 1], that must be strong for a scale to be believed."""
    least_confirmed: float = 0.6
    """The share of boxes, in [0, 1], that must be confirmed for a scale to be doubted: where most
    vanish, scores may well be low."""
    least_separation: float = 0.55
    """How often a confirmed box must score above a vanished one, in [0.5, 1]; 0.5 is chance."""

    def __post_init__(self) -> None:
        shares = self.strong, self.least_strong, self.least_confirmed
        if not (self.strong > 0.0 and all(0.0 <= share <= 1.0 for share in shares)):
            raise BadConfig(
                f"strong {self.strong:g}, least_strong {self.least_strong:g}, least_confirmed "
                f"{self.least_confirmed:g}: give shares in 0..1"
            )
        if not 0.5 <= self.least_separation <= 1.0:
            raise BadConfig(f"least_separation {self.least_separation:g}: give 0.5 to 1")

    def __call__(self, memory: ScoreMemory, detections: Detections) -> Detections:
        """The same boxes with probabilities for scores; memory: with these boxes in it."""
        scores = detections.scores
        if memory.judgement == "" and memory.low >= 0.0 and memory.high <= 1.0:
            return detections
        return detections.replaced(scores=self.probabilities(memory, scores))

    def probabilities(self, memory: ScoreMemory, scores: Float[Array, " n"]) -> Float[Array, " n"]:
        """What scores of the detector are worth."""
        if memory.says_nothing:
            return np.full(len(scores), self.strong)
        if memory.judgement == "ranked":
            return np.interp(scores, memory.landmarks, PROBABILITIES)
        return _known_scale(memory, scores)

    def watch(self, memory: ScoreMemory, detections: Detections) -> ScoreMemory:
        """What is known after these detections, the next frame's that was looked at."""
        boxes, scores = detections.boxes, detections.scores
        low, high = memory.low, memory.high
        listed = scores.tolist()  # of so few numbers Python finds the least sooner
        low, high = min((low, *listed)), max((high, *listed))
        watched = memory.watched
        if watched >= JUDGED_AT[-1]:
            is_known = low == memory.low and high == memory.high
            return memory if is_known else memory._replace(low=low, high=high)
        frames = (*memory.frames, (boxes.copy(), scores.copy()))
        now = watched + (len(memory.frames[-1][0]) if memory.frames else 0)
        after = ScoreMemory(low, high, frames, now, *memory[4:])
        if len(frames) > MOST_FRAMES:
            after = after.told_apart()
        if low == high:  # never another score
            return after._replace(judgement="even" if now + len(boxes) > 1 else "")
        if bisect(JUDGED_AT, watched) < bisect(JUDGED_AT, now) or memory.low == memory.high:
            return self._judged(after)
        return after

    def _judged(self, memory: ScoreMemory) -> ScoreMemory:
        """With the judgement that the watched boxes speak for."""
        memory = memory.told_apart()
        confirmed, vanished = memory.confirmed, memory.vanished
        watched = len(confirmed) + len(vanished)
        if len(confirmed) < max(JUDGED_AT[0] / 2, self.least_confirmed * watched):
            return memory._replace(judgement="")
        if separation(confirmed, vanished) < self.least_separation:
            return memory._replace(judgement="even")
        if np.mean(_known_scale(memory, confirmed) >= self.strong) >= self.least_strong:
            return memory._replace(judgement="")
        landmarks = np.quantile(confirmed, SHARES)
        landmarks += np.arange(len(SHARES)) * 1e-12 * max(1.0, float(np.abs(landmarks).max()))
        return memory._replace(judgement="ranked", landmarks=landmarks)


def _known_scale(memory: ScoreMemory, scores: Float[Array, " n"]) -> Float[Array, " n"]:
    """Probabilities of scores that are ones, percent, their logarithms, or logits."""
    if memory.low >= 0.0 and memory.high <= 1.0:
        return scores
    if memory.low >= 0.0 and LARGEST_LOGIT < memory.high <= 100.0:
        return scores / 100.0
    if memory.high <= 0.0:
        return np.exp(scores)
    return 1.0 / (1.0 + np.exp(-np.clip(scores, -500.0, 500.0)))


def separation(confirmed: Float[Array, " c"], vanished: Float[Array, " v"]) -> float:
    """How often a confirmed box scores above a vanished one, ties half; shrunk towards 0.75.

    The area under the curve of operating characteristics, as if ten more vanished boxes had
    been told apart in three of four cases.
    """
    if not len(confirmed):
        return 0.5
    ordered = np.sort(confirmed)
    below = np.searchsorted(ordered, vanished, side="left")
    upto = np.searchsorted(ordered, vanished, side="right")
    above = len(confirmed) - 0.5 * (below + upto)
    return float((above.sum() / len(confirmed) + 7.5) / (len(vanished) + 10.0))

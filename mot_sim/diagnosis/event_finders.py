"""Finds events in a drive: occlusions, crossings, look-alikes, turns, gaps of the detector.

Each function yields rows of `ContextEvents`. Occlusions come from exact truth or from labels.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.datasets.recorded import DetectionLog
from mot_sim.diagnosis.context_events import NO_PARTNER, SCENERY, EventRow, by_id, runs_of_frames
from mot_sim.metrics.matching import EPSILON, Overlaps, match, same_frame_pairs
from mot_sim.metrics.preprocessing import MIN_OVERLAP
from mot_sim.simulation.truth import Occlusions, Truth
from mot_sim.simulation.truth.events import hidings
from tracker.geometry import box_area, box_intersection, invert
from tracker.types import Rows, Tracks

LARGELY_OCCLUDED_LEVEL = 2  # KITTI's lowest level of a largely occluded label
MAX_OCCLUSION_GAP_FRAMES = 3  # a lower level for so long does not end an occlusion
# Share of a car's box that a nearer one must cover to count as its occluder, from labels.
MIN_COVERED_SHARE = 0.2
MIN_HIDDEN_PIXELS = 20  # an occluder hides at least so many pixels of a car
MAX_PAIR_GAP_FRAMES = 5  # two cars apart for so long are still in one event
LOOK_ALIKE_MARGIN = 0.5  # look-alikes are near if boxes touch that are grown by this share
RATE_HALF_WINDOW_FRAMES = 3  # before and after, to measure a rate: labels jitter
MIN_TURN_RATE = 0.1  # radians per second; KITTI's road bends stay below, junctions reach .3
MIN_TURN_ANGLE = 0.2  # radians
MAX_TURN_GAP_FRAMES = 5  # below the rate for so long does not end a turn


def exact_occlusions(truth: Truth, occlusions: Occlusions) -> Iterator[EventRow]:
    """Occlusions begin below .4 visible, and end above .5 or when the car leaves the image."""
    tracks = truth.tracks
    assert tracks.cuboids is not None
    keys = zip(tracks.frames.tolist(), tracks.ids.tolist(), strict=True)
    depth = dict(zip(keys, tracks.cuboids.base[:, 2].tolist(), strict=True))
    hidden_by = {car: occlusions.select(rows) for car, rows in by_id(occlusions.ids)}
    for car, rows in by_id(tracks.ids):
        seen = rows[truth.amodal_pixels[rows] > 0]
        for stay in runs_of_frames(tracks.frames[seen]):
            part = seen[stay]
            frames = tracks.frames[part].tolist()
            for first, last in _hidden(truth.visible[part].tolist(), frames, car):
                other = _occluder(hidden_by.get(car), first, last)
                gaps = [
                    depth[frame, car] - depth[frame, other]
                    for frame in range(first, last + 1)
                    if (frame, car) in depth and (frame, other) in depth
                ]
                gap = float(np.mean(gaps)) if gaps else np.nan
                yield "occlusion", first, last, car, other, gap


def _hidden(visible: list[float], frames: list[int], car: int) -> Iterator[tuple[int, int]]:
    """First and last frame of each time that a car is hidden during one stay in the image."""
    begun: int | None = None
    for frame, kind, _, _ in hidings(visible, frames, car):
        if kind == "occlusion begins":
            begun = frame
        elif begun is not None:
            yield begun, frame - 1
            begun = None
    if begun is not None:
        yield begun, frames[-1]


def _occluder(hidden: Occlusions | None, first: int, last: int) -> int:
    """The id of what hides most pixels of a car; SCENERY: no car; NO_PARTNER: hardly anything."""
    if hidden is None:
        return NO_PARTNER
    here = (hidden.frames >= first) & (hidden.frames <= last)
    total: Counter[int] = Counter()
    for by, pixels in zip(
        hidden.occluder_ids[here].tolist(), hidden.pixels[here].tolist(), strict=True
    ):
        total[by if by >= 0 else SCENERY] += pixels
    most = max(total.items(), key=lambda each: (each[1], -each[0]), default=(NO_PARTNER, 0))
    return most[0] if most[1] >= MIN_HIDDEN_PIXELS else NO_PARTNER


def labelled_occlusions(labels: Tracks) -> Iterator[EventRow]:
    """The times that labels are largely occluded (level 2 or 3), or are missing in between.

    The occluder is the nearer label that covers most of the car's box, or SCENERY.
    """
    if labels.occlusion is None:
        return
    named = labels.select((labels.ids >= 0) & _is_vehicle(labels))
    covers = _covers(labels)
    for car, rows in by_id(named.ids):
        assert named.occlusion is not None
        frames, level = named.frames[rows], named.occlusion[rows]
        bad = np.setdiff1d(
            np.arange(frames[0], frames[-1] + 1), frames[level < LARGELY_OCCLUDED_LEVEL]
        )
        for span in runs_of_frames(bad, MAX_OCCLUSION_GAP_FRAMES):
            first, last = int(bad[span][0]), int(bad[span][-1])
            other, gap = _nearest_cover(covers.get(car, []), first, last)
            yield "occlusion", first, last, car, other, gap


def _is_vehicle(labels: Tracks) -> Array:
    """Cars and vans, whose track ids are diagnosed."""
    if labels.kinds is None:
        return np.ones(len(labels), bool)
    return np.isin(labels.kinds, ("Car", "Van"))


def _covers(labels: Tracks) -> dict[int, list[tuple[int, int, float, float]]]:
    """By car: frame, id of a nearer one that covers some of its box, the share, metres nearer."""
    if labels.cuboids is None:
        return {}
    named = labels.select(labels.ids >= 0)
    assert named.cuboids is not None
    depth: Float[Array, " n"] = named.cuboids.base[:, 2]
    rows, others = same_frame_pairs(named.frames, named.frames)
    shared = box_intersection(named.boxes[rows], named.boxes[others])
    part = shared / np.maximum(box_area(named.boxes[rows]), 1e-9)
    nearer = depth[rows] - depth[others]
    hides: Int[Array, " k"] = np.flatnonzero(
        (rows != others) & (part >= MIN_COVERED_SHARE) & (nearer > 0.0)
    )
    found: dict[int, list[tuple[int, int, float, float]]] = {}
    for k in hides.tolist():
        row, other = int(rows[k]), int(others[k])
        found.setdefault(int(named.ids[row]), []).append(
            (int(named.frames[row]), int(named.ids[other]), float(part[k]), float(nearer[k]))
        )
    return found


def _nearest_cover(
    covers: list[tuple[int, int, float, float]], first: int, last: int
) -> tuple[int, float]:
    """The id of what covers a car most over some frames and their neighbours; metres nearer."""
    total: dict[int, float] = {}
    gaps: dict[int, list[float]] = {}
    for frame, other, part, gap in covers:
        if first - MAX_OCCLUSION_GAP_FRAMES <= frame <= last + MAX_OCCLUSION_GAP_FRAMES:
            total[other] = total.get(other, 0.0) + part
            gaps.setdefault(other, []).append(gap)
    if not total:
        return SCENERY, np.nan
    most = max(total, key=lambda each: (total[each], -each))
    return most, float(np.mean(gaps[most]))


def box_crossings(cars: Tracks) -> Iterator[EventRow]:
    """Pairs of cars whose boxes share area and whose centres change sides meanwhile."""
    for a, b, frames, rows_a, rows_b in pair_events(cars, cars.boxes):
        middle = cars.boxes[:, 0] + cars.boxes[:, 2]
        side = np.sign(middle[rows_a] - middle[rows_b])
        if (side > 0).any() and (side < 0).any():
            yield "crossing", int(frames[0]), int(frames[-1]), a, b, np.nan


def look_alike_pairs(
    cars: Tracks, ids: Int[Array, " n"], looks: Shaped[Array, " n"]
) -> Iterator[EventRow]:
    """Pairs of near cars that look alike. looks: of the sorted ids; equal numbers look alike."""
    look = looks[np.searchsorted(ids, cars.ids)] if len(ids) else looks
    sides = LOOK_ALIKE_MARGIN * 0.5 * (cars.boxes[:, 2:] - cars.boxes[:, :2])
    grown = np.concatenate((cars.boxes[:, :2] - sides, cars.boxes[:, 2:] + sides), axis=1)
    for a, b, frames, rows_a, rows_b in pair_events(cars, grown):
        if look[rows_a[0]] == look[rows_b[0]]:
            yield "look-alike", int(frames[0]), int(frames[-1]), a, b, np.nan


def pair_events(
    cars: Tracks, boxes: Float[Array, "n 4"]
) -> Iterator[tuple[int, int, Int[Array, " k"], Int[Array, " k"], Int[Array, " k"]]]:
    """The times that the boxes of two cars share area: both ids, the frames, the rows of both."""
    pairs = CarPairs.of(cars, boxes)
    keys = np.stack((pairs.firsts, pairs.seconds), axis=1)
    if not len(keys):
        return
    every, which = np.unique(keys, axis=0, return_inverse=True)
    for number, (a, b) in enumerate(every.tolist()):
        own = pairs.select(np.flatnonzero(which.ravel() == number))
        for span in runs_of_frames(own.frames, MAX_PAIR_GAP_FRAMES):
            part = own.select(span)
            yield a, b, part.frames, part.rows_a, part.rows_b


@dataclass(frozen=True, eq=False)
class CarPairs(Rows):
    """Pairs of cars whose boxes share area: one row per pair and frame."""

    frames: Int[Array, " n"]
    """Frame of each pair."""
    firsts: Int[Array, " n"]
    """The lower of the two label ids."""
    seconds: Int[Array, " n"]
    """The higher of the two label ids."""
    rows_a: Int[Array, " n"]
    """Row of the car with the lower id in the table of labels."""
    rows_b: Int[Array, " n"]
    """Row of the car with the higher id in the table of labels."""

    @classmethod
    def of(cls, cars: Tracks, boxes: Float[Array, "n 4"]) -> "CarPairs":
        """The cars whose boxes share area, the lower id first; in the order of frames."""
        rows, others = same_frame_pairs(cars.frames, cars.frames)
        low = cars.ids[rows] < cars.ids[others]
        rows, others = rows[low], others[low]
        near = box_intersection(boxes[rows], boxes[others]) > 0.0
        rows, others = rows[near], others[near]
        return cls(cars.frames[rows], cars.ids[rows], cars.ids[others], rows, others)


def headings_of(Ts_world_cam: Float[Array, "m 4 4"]) -> Float[Array, " m"]:
    """How far the camera has turned right since the first frame, radians."""
    if not len(Ts_world_cam):
        return np.zeros(0)
    ahead = (invert(Ts_world_cam[:-1]) @ Ts_world_cam[1:])[:, :3, 2]
    return np.concatenate(([0.0], np.cumsum(np.arctan2(ahead[:, 0], ahead[:, 2]))))


def camera_turns(
    cars: Tracks, headings: Float[Array, " m"], frame_rate: float
) -> Iterator[EventRow]:
    """Turns of the camera: one row for each car that is in the image meanwhile."""
    every = np.arange(len(headings))
    for first, last in _turns(every, headings, frame_rate):
        here = (cars.frames >= first) & (cars.frames <= last)
        for car, rows in by_id(cars.ids[here]):
            frames = cars.frames[here][rows]
            yield "camera turns", int(frames[0]), int(frames[-1]), car, NO_PARTNER, np.nan


def car_turns(cars: Tracks, headings: Float[Array, " m"], frame_rate: float) -> Iterator[EventRow]:
    """Turns of cars in the world; rows without a cuboid are skipped."""
    if cars.cuboids is None:
        return
    known = cars.select(np.isfinite(cars.cuboids.yaw))
    assert known.cuboids is not None
    # The road frame turns with the camera: yaw = heading of the car - heading of the camera - pi/2.
    yaw = known.cuboids.yaw + headings[known.frames]
    for car, rows in by_id(known.ids):
        for part in runs_of_frames(known.frames[rows], MAX_TURN_GAP_FRAMES):
            own = rows[part]
            for first, last in _turns(known.frames[own], np.unwrap(yaw[own]), frame_rate):
                yield "car turns", first, last, car, NO_PARTNER, np.nan


def _turns(
    frames: Int[Array, " k"], headings: Float[Array, " k"], frame_rate: float
) -> Iterator[tuple[int, int]]:
    """First and last frame of each time that a heading changes fast, and far enough."""
    if len(frames) < 2:
        return
    at = np.arange(len(frames))
    before = np.maximum(at - RATE_HALF_WINDOW_FRAMES, 0)
    after = np.minimum(at + RATE_HALF_WINDOW_FRAMES, len(frames) - 1)
    seconds = (frames[after] - frames[before]) / frame_rate
    fast = np.flatnonzero(np.abs(headings[after] - headings[before]) > MIN_TURN_RATE * seconds)
    for span in runs_of_frames(fast, MAX_TURN_GAP_FRAMES):
        part = fast[span]
        turned = headings[after[part[-1]]] - headings[before[part[0]]]
        if abs(float(turned)) >= MIN_TURN_ANGLE:
            yield int(frames[part[0]]), int(frames[part[-1]])


def detector_gaps(cars: Tracks, log: DetectionLog, frames: Int[Array, " k"]) -> Iterator[EventRow]:
    """Frames without a box for a car that was detected before and is again later.

    frames: those that are delivered. A car is detected where a box of any score overlaps its
    label by half; each box counts for one car.
    """
    cars = cars.select(np.isin(cars.frames, frames))
    detected = _detected(cars, log)
    for car, rows in by_id(cars.ids):
        seen = np.flatnonzero(detected[rows])
        if not len(seen):
            continue
        inner = rows[seen[0] : seen[-1] + 1]
        # Frames that are not delivered neither make nor end a gap.
        steps = np.searchsorted(frames, cars.frames[inner])
        found = steps[detected[inner]]
        for a, b in zip(found[:-1].tolist(), found[1:].tolist(), strict=True):
            if b > a + 1:
                first, last = int(frames[a + 1]), int(frames[b - 1])
                yield "detector gap", first, last, car, NO_PARTNER, np.nan


def _detected(cars: Tracks, log: DetectionLog) -> Array:
    """Which labels have a box; in each frame the largest overlap is matched first."""
    boxes = Tracks(log.frames, np.arange(len(log.frames)), log.detections.boxes)
    overlaps = Overlaps.between(cars, boxes)
    near = np.flatnonzero(overlaps.iou >= MIN_OVERLAP - EPSILON)
    found = np.zeros(len(cars), bool)
    found[overlaps.rows[match(overlaps, near, overlaps.iou[near])]] = True
    return found

"""When cars are hidden, by whom, and how much nearer that is: from exact truth, or from labels."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from mot_sim.diagnosis.context_events import NO_PARTNER, SCENERY, EventRow
from mot_sim.diagnosis.runs_of_frames import by_id, runs_of_frames
from mot_sim.metrics.overlaps import same_frame_pairs
from mot_sim.simulation.truth import Occlusions, Truth
from mot_sim.simulation.truth.events import hidings
from tracker.geometry import box_area, box_intersection
from tracker.types import Tracks

LARGELY_OCCLUDED_LEVEL = 2  # KITTI's level from which on a label is largely occluded
MAX_OCCLUSION_GAP_FRAMES = 3  # frames that a level may change for without ending an occlusion
# Part of a car's box that a nearer one must cover to be what hides it, where only labels are known.
MIN_COVERED_SHARE = 0.2
MIN_HIDDEN_PIXELS = 20  # pixels; fewer do not hide a car


def exact_occlusions(truth: Truth, occlusions: Occlusions) -> Iterator[EventRow]:
    """The times that cars are less than .4 visible, until they are above .5 or leave the image."""
    tracks = truth.tracks
    assert tracks.cuboids is not None
    depth = {
        (frame, car): z
        for frame, car, z in zip(
            tracks.frames.tolist(), tracks.ids.tolist(), tracks.cuboids.base[:, 2].tolist(),
            strict=True,
        )
    }  # fmt: skip
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
    """Who hides most pixels of a car over some frames; -1: no car does, -2: hardly anything."""
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
    """The times that labels are largely occluded (level 2 or 3), or that a label skips.

    What hides a car: the nearer label that covers most of its box; -1: none does.
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
    """Cars and vans: whose names are looked at."""
    if labels.kinds is None:
        return np.ones(len(labels), bool)
    return np.isin(labels.kinds, ("Car", "Van"))


def _covers(labels: Tracks) -> dict[int, list[tuple[int, int, float, float]]]:
    """By car: frame, who covers some of its box and is nearer, the part, and metres nearer."""
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
    """Who covers a car most over some frames and their neighbours, and how much nearer it is."""
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


__all__ = ["exact_occlusions", "labelled_occlusions"]

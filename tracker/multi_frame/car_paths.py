"""The states of cars along tracks that are decided: filtered and smoothed, row by row."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.car_filter import (
    CarFilter,
    FilteredFrame,
    FollowedCars,
    SeenCars,
    follow_cars,
    smooth_cars,
)
from tracker.multi_frame.linking import NO_ROWS, FrameNodes
from tracker.tracker import Tracker
from tracker.types import CarEstimates, Tracks

# From a frame's index to the tracks in it and their cars.
CarsByFrame = dict[int, tuple[Int[Array, " n"], CarEstimates]]


def no_rows(tracker: Tracker) -> Tracks:
    """What a step without any row gives: it has the columns that the others have."""
    if tracker.car_filter is None:
        return NO_ROWS
    return replace(NO_ROWS, estimates=CarEstimates.unknown(0))


class FilteredNodes(NamedTuple):
    """One frame of the forward pass, and what it was made of."""

    nodes: Int[Array, " k"]
    """The nodes of the frame that belong to tracks."""
    ids: Int[Array, " k"]
    """The tracks that they belong to."""
    frame: FilteredFrame
    """The cars after them."""

    def is_of(self, nodes: Int[Array, " k"], ids: Int[Array, " k"]) -> bool:
        """Whether it was made of these."""
        return np.array_equal(self.nodes, nodes) and np.array_equal(self.ids, ids)


def filter_tracks(
    tracker: Tracker,
    car_filter: CarFilter,
    frames: Sequence[FrameNodes],
    paths: Mapping[int, Int[Array, " k"]],
    start: FollowedCars,
    last: Mapping[int, int],
    done: Sequence[FilteredNodes] = (),
) -> list[FilteredNodes]:
    """The forward pass over the frames that were looked at.

    paths: from a track's id to its nodes, of which those in these frames count. A car is followed
    from its first node, or from the start, to the frame of the node in `last`. done: an earlier
    pass from the same start; its first frames are taken as long as they were made of these nodes.
    """
    nodes = np.concatenate([np.zeros(0, np.int64), *paths.values()])
    ids = np.repeat(np.array(list(paths), np.int64), [len(path) for path in paths.values()])
    order = np.argsort(nodes)
    nodes, ids = nodes[order], ids[order]
    filtered: list[FilteredNodes] = []
    cars, is_done = start, True
    for frame in frames:
        if not frame.is_looked_at:
            continue
        here = slice(*np.searchsorted(nodes, (frame.first, frame.end)).tolist())
        number = len(filtered)
        is_done = is_done and number < len(done) and done[number].is_of(nodes[here], ids[here])
        if is_done:
            filtered.append(done[number])
            cars = done[number].frame.cars
            continue
        rows, boxes = nodes[here] - frame.first, frame.detections.boxes
        seen = SeenCars(
            frame.dt,
            frame.T_now_before,
            frame.motion_cov,
            ids[here],
            frame.detections.select(rows),
            frame.observed.cuboids.base[rows],
            boxes,
        )
        kept = np.array([last.get(i, -1) >= frame.first for i in cars.ids.tolist()], bool)
        followed = follow_cars(car_filter, cars, seen, kept, tracker.camera)
        filtered.append(FilteredNodes(nodes[here], ids[here], followed))
        cars = followed.cars
    return filtered


def filter_whole_tracks(
    tracker: Tracker,
    car_filter: CarFilter,
    frames: Sequence[FrameNodes],
    paths: Mapping[int, Int[Array, " k"]],
) -> list[FilteredNodes]:
    """The forward pass over tracks that begin and end in these frames."""
    last = {track_id: int(path[-1]) for track_id, path in paths.items()}
    return filter_tracks(tracker, car_filter, frames, paths, FollowedCars.none(), last)


def filtered_cars(
    car_filter: CarFilter, frames: Sequence[FrameNodes], filtered: Sequence[FilteredNodes]
) -> CarsByFrame:
    """The cars of every frame that was looked at, by the frames until then."""
    looked_at = [frame.index for frame in frames if frame.is_looked_at]
    cars = [each.frame.cars for each in filtered]
    return {
        index: (each.ids, car_filter.estimate(each.states, each.memory))
        for index, each in zip(looked_at, cars, strict=True)
    }


def smoothed_cars(
    car_filter: CarFilter, frames: Sequence[FrameNodes], filtered: Sequence[FilteredNodes]
) -> CarsByFrame:
    """The cars of every frame that was looked at, by all of these frames."""
    looked_at = [frame.index for frame in frames if frame.is_looked_at]
    backwards = zip(reversed(looked_at), reversed(filtered), strict=True)
    smoothed = smooth_cars(car_filter, [each.frame for each in filtered])
    return {
        index: (each.frame.cars.ids, cars)
        for (index, each), cars in zip(backwards, smoothed, strict=True)
    }


def with_cars(rows: Tracks, cars: CarsByFrame) -> Tracks:
    """The rows with these states and their cuboids; other rows keep theirs, their state unknown."""
    means, covs, heading_known = _columns(CarEstimates.unknown(len(rows)))
    for index in np.unique(rows.frames).tolist():
        if index not in cars:
            continue
        ids, estimates = cars[index]
        at = np.flatnonzero(rows.frames == index)
        order = np.argsort(ids)
        found = np.isin(rows.ids[at], ids)
        source = order[np.searchsorted(ids, rows.ids[at[found]], sorter=order)]
        for column, values in zip((means, covs, heading_known), _columns(estimates), strict=True):
            column[at[found]] = values[source]
    states = CarEstimates(means, covs, heading_known)
    known = np.isfinite(heading_known).nonzero()[0]
    assert rows.cuboids is not None
    cuboids = rows.cuboids.updated(known, states.select(known).cuboids())
    return rows.replaced(cuboids=cuboids, estimates=states)


def _columns(
    cars: CarEstimates,
) -> tuple[Float[Array, "n 9"], Float[Array, "n 9 9"], Float[Array, " n"]]:
    """Means, covariances, and how sure the headings are."""
    return cars.means, cars.covs, cars.heading_known

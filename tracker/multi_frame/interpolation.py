"""A track in every frame from its first detection to its last: gaps are filled in.

After the last one it goes on through the frames that nothing looked at.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray as Array

from tracker.beliefs import MIN_DEPTH, Beliefs
from tracker.geometry import invert
from tracker.multi_frame.linking import FrameNodes
from tracker.smoothing import smoothed
from tracker.types import Camera, Cuboids, Tracks


def fill_gaps(
    frames: Sequence[FrameNodes],
    nodes: Int[Array, " k"],
    track_id: int,
    camera: Camera,
    acceleration_std: float,
) -> Tracks:
    """The rows of one track: its detections, and boxes in the gaps between them.

    frames: all of a stretch of time; nodes: of the track, increasing, all in these frames. The
    car's path over the road is smoothed through all its detections; in a gap its box stands on
    the path, with an outline (in metres about its place) between those of the two detections
    around the gap, and the smaller score of the two. A box outside the image is left out. After
    the last detection the path goes on as it went, until the next frame that was looked at.
    """
    firsts = np.array([frame.first for frame in frames])
    at = np.searchsorted(firsts, nodes, side="right") - 1
    places = list(zip(at.tolist(), (nodes - firsts[at]).tolist(), strict=True))
    observed = Beliefs.concatenate([frames[k].observed.select([row]) for k, row in places])
    scores = np.array([frames[k].detections.scores[row] for k, row in places])
    span = frames[at[0] : _until_next_look(frames, int(at[-1]))]
    known = at - at[0]  # the frames of the span with a detection
    times = np.array([frame.time for frame in span])
    velocity = span[0].beliefs.velocity[places[0][1]]
    cuboids = _cuboids(span, times, known, observed, velocity, acceleration_std)
    boxes, depth = _boxes(cuboids, times, known, observed.boxes, camera)
    boxes[known] = observed.boxes
    kept = (boxes[:, 2] > boxes[:, 0]) & (boxes[:, 3] > boxes[:, 1])
    kept[known[-1] :] &= depth[known[-1] :] > MIN_DEPTH
    kept[known] = True
    before = np.searchsorted(known, np.arange(len(span)), side="right") - 1
    after = np.minimum(np.searchsorted(known, np.arange(len(span))), len(known) - 1)
    indices = np.array([frame.index for frame in span])
    ids = np.full(len(span), track_id)
    filled = np.minimum(scores[before], scores[after])
    return Tracks(indices, ids, boxes, filled, cuboids=cuboids).select(kept)


def _until_next_look(frames: Sequence[FrameNodes], last: int) -> int:
    """The first frame after `last` that a detector looked at; their number where none did."""
    later = range(last + 1, len(frames))
    return next((place for place in later if frames[place].is_looked_at), len(frames))


def interpolate(
    times: Float[Array, " n"], known: Int[Array, " k"], values: Float[Array, "k c"]
) -> Float[Array, "n c"]:
    """The columns at all times, linear between the known ones."""
    columns = [np.interp(times, times[known], column) for column in values.T]
    return np.stack(columns, axis=1)


def _cuboids(
    span: Sequence[FrameNodes],
    times: Float[Array, " n"],
    known: Int[Array, " k"],
    observed: Beliefs,
    velocity: Float[Array, "2"],
    acceleration_std: float,
) -> Cuboids:
    """The car in every frame's road frame, its path smoothed in that of the first.

    velocity: at the first detection, as filtered until then, along its road's x and z.
    """
    Ts_world_road = np.array([frame.T_world_road for frame in span])
    R, t = Ts_world_road[known, :3:2, :3:2], Ts_world_road[known, :3:2, 3]
    places = (R @ observed.cuboids.base[:, ::2, None])[:, :, 0] + t
    covs = R @ observed.cov[:, :2, :2] @ R.transpose(0, 2, 1)
    if len(known) > 1:
        path = smoothed(times, known, places, covs, acceleration_std).states[:, :2]
    else:  # how a car goes on after one place tells what was filtered until there
        path = places + (times - times[0])[:, None] * (R[0] @ velocity)
    Ts_road_world = invert(Ts_world_road)
    base = np.empty((len(span), 3))
    base[:, ::2] = (Ts_road_world[:, :3:2, :3:2] @ path[:, :, None])[:, :, 0]
    base[:, ::2] += Ts_road_world[:, :3:2, 3]
    base[:, 1] = interpolate(times, known, observed.cuboids.base[:, 1:2])[:, 0]
    yaw = interpolate(times, known, np.unwrap(observed.cuboids.yaw)[:, None])[:, 0]
    return Cuboids(base, yaw, interpolate(times, known, observed.cuboids.size))


def _boxes(
    cuboids: Cuboids,
    times: Float[Array, " n"],
    known: Int[Array, " k"],
    boxes: Float[Array, "k 4"],
    camera: Camera,
) -> tuple[Float[Array, "n 4"], Float[Array, " n"]]:
    """The boxes at all times, clipped to the image: outlines that move with the cuboids; depths."""
    on_road = cuboids.base * (1.0, 0.0, 1.0)
    pixels = (on_road @ camera.T_cam_road[:3, :3].T + camera.T_cam_road[:3, 3]) @ camera.K.T
    depth = np.maximum(pixels[:, 2:], MIN_DEPTH)
    place = np.tile(pixels[:, :2] / depth, (1, 2))
    outline = interpolate(times, known, (boxes - place[known]) * depth[known])
    return camera.clip_boxes(place + outline / depth), pixels[:, 2]

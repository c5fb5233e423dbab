"""What a tracker believes of cars, with its covariance: a CSV file beside the file of results.

KITTI's rows have no column for it, and their readers refuse or misread further ones.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.datasets.detection_files import SIZE_COLUMNS
from mot_sim.files.text import TextTable, read_table
from mot_sim.files.writing import is_stream, write_lines
from tracker.errors import BadFile, BadOutput, BadTracks
from tracker.geometry import invert, transform, wrap_angle
from tracker.types import CarEstimates, Tracks

ESTIMATES_SUFFIX = ".estimates.csv"
# The parts of a state, in the order of `CarEstimates.means`; sizes are written in metres.
STATE_PARTS = ("x", "y", "z", "yaw", "speed", "log_length", "log_height", "log_width", "yaw_rate")
MEAN_COLUMNS = ("x_m", "y_m", "z_m", "yaw", "speed", *SIZE_COLUMNS, "yaw_rate")
UPPER = np.triu_indices(len(STATE_PARTS))
COV_COLUMNS = tuple(f"cov_{STATE_PARTS[a]}_{STATE_PARTS[b]}" for a, b in zip(*UPPER, strict=True))
COLUMNS = ("frame", "id", *MEAN_COLUMNS, "heading_known", *COV_COLUMNS)
YAW = STATE_PARTS.index("yaw")
PLACE = slice(0, 3)
SIZE = slice(STATE_PARTS.index("log_length"), STATE_PARTS.index("log_width") + 1)
# Numbers are written with nine digits: an eigenvalue of correlations may come out below 0 by this.
MAX_BELOW = 1e-6
# Metres that a state may be off the cuboid of its row, which has six decimals.
MAX_APART = 1e-3
MAX_SIZE = 1000.0  # metres; what is computed from its logarithm stays finite


def estimates_path(results: Path) -> Path:
    """Where the states of a file of results lie: 0000.estimates.csv beside 0000.txt."""
    return results.with_suffix(ESTIMATES_SUFFIX)


def write_estimates(
    tracks: Tracks, results: Path, T_road_label: Float[Array, "4 4"] | None
) -> None:
    """Write the states of the tracks beside their results, or remove those that lie there.

    Places stand in the frame of the results, camera 0, and so does their covariance; yaw is about
    the road's normal. Rows without a state are left out; nine digits. Without T_road_label there
    are no states, as there are no cuboids, and nothing is written beside a pipe. Raises BadTracks
    for states that are finite in part, BadOutput where nothing can be written or removed.
    """
    if is_stream(results):
        return
    path, states = estimates_path(results), tracks.estimates
    if states is None or T_road_label is None:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            what = f"cannot be removed, and is of older results: {error.strerror or error}"
            raise BadOutput(f"{path}: {what}") from None
        return
    parts = [states.means, states.covs.reshape(len(states), -1), states.heading_known[:, None]]
    finite = np.isfinite(np.hstack(parts))
    known = np.asarray(finite.all(axis=1))
    if (finite.any(axis=1) & ~known).any():
        row = int(np.flatnonzero(finite.any(axis=1) & ~known)[0])
        raise BadTracks(
            f"{path}: the state of id {tracks.ids[row]} in frame {tracks.frames[row]} is finite in "
            f"part only: {states.means[row].tolist()}; give NaN for all of it, or for nothing"
        )
    rows = np.flatnonzero(known)
    rows = rows[np.argsort(tracks.frames[rows], kind="stable")]
    moved = _moved(states.select(rows), invert(T_road_label))
    write_lines(path, _lines(tracks.frames[rows], tracks.ids[rows], moved))


def _moved(states: CarEstimates, T: Float[Array, "4 4"]) -> CarEstimates:
    """The same states with their places in another frame; yaws are about the road's normal."""
    means = states.means.copy()
    means[:, PLACE] = transform(T, means[:, PLACE])
    turn = np.eye(len(STATE_PARTS))
    turn[PLACE, PLACE] = T[:3, :3]
    covs = turn @ states.covs @ turn.T
    return CarEstimates(means, 0.5 * (covs + covs.transpose(0, 2, 1)), states.heading_known)


def _lines(frames: Int[Array, " n"], ids: Int[Array, " n"], states: CarEstimates) -> Iterator[str]:
    means = states.means.copy()
    means[:, SIZE] = np.exp(means[:, SIZE])
    numbers = np.column_stack([means, states.heading_known, states.covs[:, UPPER[0], UPPER[1]]])
    yield ",".join(COLUMNS)
    row = "%d,%d" + ",%.9g" * numbers.shape[1]
    for frame, track_id, values in zip(
        frames.tolist(), ids.tolist(), numbers.tolist(), strict=True
    ):
        yield row % (frame, track_id, *values)


def read_estimates(
    path: Path, T_road_label: Float[Array, "4 4"]
) -> tuple[Int[Array, " n"], Int[Array, " n"], CarEstimates]:
    """Frames, ids and states of a file that `write_estimates` wrote; yaws beyond pi are wrapped.

    Raises BadFile with file, line and value for missing columns, numbers that are not finite,
    sizes that are not positive, probabilities outside 0..1, covariances that are none, and an
    id twice in a frame.
    """
    table = read_table(path, lambda fields: _named(path, fields), ",", header=True)
    frames, ids = table.frames(), table.integers("id", 0)
    table.reject_repeated(frames, ids)
    means = table.finite(MEAN_COLUMNS)
    sizes = means[:, SIZE]
    flat = np.asarray((sizes <= 0.0).any(axis=1))
    table.reject(flat, "a size that is not positive", SIZE_COLUMNS, "write metres above 0")
    huge = np.asarray((sizes > MAX_SIZE).any(axis=1))
    table.reject(huge, "a size of no vehicle", SIZE_COLUMNS, "write metres, not millimetres")
    means[:, SIZE] = np.log(sizes)
    beyond = np.abs(means[:, YAW]) > np.pi
    means[beyond, YAW] = wrap_angle(means[beyond, YAW])
    known = table.finite(["heading_known"])[:, 0]
    outside = (known < 0.0) | (known > 1.0)
    table.reject(
        outside, "no probability", ["heading_known"],
        "it is that of facing where yaw says and not the other way round, 0.5 to 1",
    )  # fmt: skip
    return frames, ids, _moved(CarEstimates(means, _covariances(table), known), T_road_label)


def _named(path: Path, fields: list[str]) -> list[str]:
    """The columns that the header names; BadFile where one lacks, is unknown or stands twice."""
    shown = ",".join(fields)[:80]
    lacking = next((column for column in COLUMNS if column not in fields), None)
    if lacking is not None:
        raise BadFile(f"{path}:1: no column {lacking} in {shown!r}; see write_estimates for all")
    strange = next((name for name in fields if name not in COLUMNS or fields.count(name) > 1), None)
    if strange is not None:
        what = "stands twice" if strange in COLUMNS else "is unknown"
        raise BadFile(f"{path}:1: the column {strange!r:.40} {what}; leave it out")
    return fields


def _covariances(table: TextTable) -> Float[Array, "n 9 9"]:
    """The covariances of a table; BadFile for what is none."""
    covs = np.zeros((len(table), len(STATE_PARTS), len(STATE_PARTS)))
    covs[:, UPPER[0], UPPER[1]] = covs[:, UPPER[1], UPPER[0]] = table.finite(COV_COLUMNS)
    variances = np.diagonal(covs, axis1=1, axis2=2)
    for part, name in enumerate(STATE_PARTS):
        column = f"cov_{name}_{name}"
        table.reject(variances[:, part] < 0.0, "no variance", [column], "variances are 0 or more")
    std = np.sqrt(np.where(variances > 0.0, variances, 1.0))
    correlations = covs / (std[:, :, None] * std[:, None, :])
    below = _smallest(correlations) < -MAX_BELOW
    table.reject(
        below, "a covariance that is not positive: no numbers vary so together", ["frame", "id"],
        "write the covariance of (" + ", ".join(STATE_PARTS) + ")",
    )  # fmt: skip
    return covs


def _smallest(matrices: Float[Array, "n 9 9"]) -> Float[Array, " n"]:
    """The smallest eigenvalue of each."""
    return np.asarray(np.linalg.eigvalsh(matrices)[:, 0])


def with_estimates(tracks: Tracks, results: Path, T_road_label: Float[Array, "4 4"]) -> Tracks:
    """The tracks of a file of results, with the states beside it; NaN where a row has none.

    Without such a file the tracks as they are. Raises BadFile as `read_estimates`, and for states
    that stand elsewhere than the cuboids of the results: they are of other tracks.
    """
    path = estimates_path(results)
    if tracks.cuboids is None or not path.is_file():
        return tracks
    frames, ids, states = read_estimates(path, T_road_label)
    row_of = {key: row for row, key in enumerate(zip(frames.tolist(), ids.tolist(), strict=True))}
    keys = zip(tracks.frames.tolist(), tracks.ids.tolist(), strict=True)
    rows = np.array([row_of.get(key, -1) for key in keys], dtype=np.int64)
    there = np.flatnonzero(rows >= 0)
    found = states.select(rows[there])
    _require_alike(tracks.select(there), found, path, results)
    joined = CarEstimates.unknown(len(tracks)).updated(there, found)
    return tracks.replaced(estimates=joined)


def _require_alike(tracks: Tracks, states: CarEstimates, path: Path, results: Path) -> None:
    """Raise BadFile for states that stand elsewhere than the cuboids of their rows."""
    assert tracks.cuboids is not None
    off = np.abs(states.means[:, :3] - tracks.cuboids.base).max(axis=1, initial=0.0)
    apart: Bool[Array, " n"] = ~(off <= MAX_APART)
    if not apart.any():
        return
    row = int(np.flatnonzero(apart)[0])
    raise BadFile(
        f"{path}: id {tracks.ids[row]} in frame {tracks.frames[row]} stands at "
        f"{np.round(states.means[row, :3], 3).tolist()} (road frame, m), in {results.name} at "
        f"{np.round(tracks.cuboids.base[row], 3).tolist()}: it belongs to other results; remove "
        "it, or track again"
    )

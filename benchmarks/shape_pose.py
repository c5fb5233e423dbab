"""Shape and pose of tracks against the truth of made scenes, over the noise of the cues.

    python -m benchmarks.shape_pose [--scenes intersection roundabout] [--seeds 3] [--frames 100]

Cars are seen with exact boxes (profile `cues`), and with yaw, size, shape and keypoints as noisy as
the factor says; or with their boxes alone. The default tracker follows them. Of every row that
meets a car in the image: how far centre and heading are off, how far length, height and width,
the shape (eq. 1; root mean square over the coefficients, in the prior's deviations: the mean car
is off by 1), and the car's keypoints, placed by the track's cuboid and shape, in pixels and in
percent of the box's height. Boxes are those of the drawn cars, whose corners are round; KITTI's
labels, and so detectors learned from them, have the boxes of cuboids: of these, too. Seeds begin at
3000: nothing is tuned or reported on them elsewhere.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy import ndarray as Array
from rich.console import Console

from mot_sim.experiments.sweep.conditions import Conditions
from mot_sim.experiments.sweep.drives import Recordings, drive_of
from mot_sim.experiments.sweep.paths import Level
from mot_sim.metrics.cuboid_errors import CuboidErrors, cuboid_errors, median
from mot_sim.simulation.episodes.extra import Extra
from mot_sim.simulation.sensors.sightings import Sightings
from mot_sim.simulation.truth import boxes_in_image
from mot_sim.simulation.truth.table import KeypointVisibility
from mot_sim.tables import Column, Table
from mot_sim.tables.columns import Cell, Row
from tracker import Detections, Frame, Tracker, Tracks
from tracker.geometry import invert, transform
from tracker.shape import KEYPOINTS_36, CarModel, load_prior
from tracker.types import Camera, Cuboids

SCENES = ("intersection", "roundabout", "t_junction")
FIRST_SEED = 3000
# Whose boxes cars are seen with, and the factor on the noise of the cues; None: boxes alone.
DRAWN, CUBOIDS = "drawn cars", "cuboids"
ROWS: tuple[tuple[str, float | None], ...] = (
    (DRAWN, None), (DRAWN, 0.0), (DRAWN, 0.5), (DRAWN, 1.0), (DRAWN, 2.0),
    (CUBOIDS, None), (CUBOIDS, 0.0), (CUBOIDS, 1.0),
)  # fmt: skip
COLUMNS = (
    Column("scene", "name"), Column("boxes", "name"), Column("cues", "name"),
    Column("rows", "count"),
    Column("centre, m", "value", digits=2), Column("in 2 m", "rate"),
    Column("yaw, deg", "value", digits=1), Column("> 30°", "rate"), Column("> 90°", "rate"),
    Column("length, m", "value", digits=2), Column("height, m", "value", digits=2),
    Column("width, m", "value", digits=2), Column("shape, std", "value", digits=2),
    Column("keypoints, px", "value", digits=1), Column("% of height", "value", digits=1),
)  # fmt: skip


def main() -> None:
    """Print the table, as Markdown with --markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--markdown", action="store_true")
    told = parser.parse_args()
    rows: list[Row] = []
    with TemporaryDirectory() as folder:
        for scene in told.scenes:
            for boxes, factor in ROWS:
                parts = [
                    measure(scene, FIRST_SEED + seed, told.frames, boxes, factor, Path(folder))
                    for seed in range(told.seeds)
                ]
                rows.append(row_of((scene, boxes), factor, parts))
    table = Table(COLUMNS, tuple(rows), "Shape and pose of tracks, medians over rows")
    print(table.as_markdown()) if told.markdown else Console(width=200).print(table)


def measure(
    scene: str, seed: int, frames: int, boxes: str, factor: float | None, folder: Path
) -> tuple[CuboidErrors, Array, Array, Array]:
    """The errors of one run: of cuboids; of shapes, keypoints in pixels and as shares of height.

    boxes, factor: see ROWS.
    """
    settings: dict[str, Level] = {
        "scene.profile": "cues", "scene.frames": frames, "detector.cues": factor or 0.0
    }  # fmt: skip
    conditions = Conditions.of(scene, settings)
    recorded = Recordings(folder).truth(conditions, seed)
    if boxes == CUBOIDS:
        recorded = with_boxes_of_cuboids(recorded)
    drive = drive_of(conditions, recorded, seed)
    tracker = Tracker.default(drive.sequence.camera)
    rows, shapes = [], []
    for frame in drive.sequence:
        rows.append(tracker.step(frame if factor is not None else boxes_alone(frame)))
        shapes.append(shapes_of(tracker, rows[-1], recorded.vehicles.coefficients.shape[1]))
    output, shape = Tracks.concatenate(rows), np.concatenate(shapes)
    errors = cuboid_errors(
        drive.truth, output, drive.frame_count, drive.Ts_world_road, drive.frame_rate
    )
    return errors, *against_truth(errors, output, shape, recorded, drive.sequence.camera)


def with_boxes_of_cuboids(recorded: Extra) -> Extra:
    """The same run, whose cars are labelled with the boxes of their cuboids."""
    annotations = recorded.annotations
    tracks = annotations.truth.tracks
    assert tracks.cuboids is not None
    tracks = tracks.replaced(boxes=boxes_in_image(tracks.cuboids, recorded.camera))
    truth = annotations.truth.replaced(tracks=tracks)
    return replace(recorded, annotations=replace(annotations, truth=truth))


def boxes_alone(frame: Frame) -> Frame:
    """The same frame without cues."""
    found = frame.detections
    bare = None if found is None else Detections(found.boxes, found.scores)
    return replace(frame, detections=bare)


def shapes_of(tracker: Tracker, rows: Tracks, size: int) -> Array:
    """The coefficients that the tracker remembers of each row's car; NaN: it never saw any."""
    tracks = tracker.state.tracks
    shape = np.full((len(rows), size), np.nan)
    if tracks.beliefs.shape_pose is not None:
        place = {name: row for row, name in enumerate(tracks.ids.tolist())}
        known = [row for row, name in enumerate(rows.ids.tolist()) if name in place]
        mine = [place[name] for name in rows.ids[known].tolist()]
        shape[known] = tracks.beliefs.shape_pose.shape[mine]
    return shape


def against_truth(
    errors: CuboidErrors, output: Tracks, shape: Array, recorded: Extra, camera: Camera
) -> tuple[Array, Array, Array]:
    """Errors of shape (in deviations), and of keypoints in pixels and as shares of box heights."""
    true = Sightings.from_truth(recorded.annotations.truth, recorded.vehicles)
    theirs = rows_at(true.frames, true.ids, errors.frames, errors.truth_ids)
    ours = rows_at(output.frames, output.ids, errors.frames, errors.output_ids)
    assert true.shape is not None
    assert true.keypoints is not None
    assert true.keypoint_states is not None
    assert output.cuboids is not None
    model = CarModel(load_prior(points=KEYPOINTS_36).first(shape.shape[1]))
    off = (shape[ours] - true.shape[theirs]) / model.std
    known = np.where(np.isfinite(shape[ours]), shape[ours], 0.0)  # the mean car
    pixels = keypoints_of(output.cuboids.select(ours), known, model, camera)
    apart = np.linalg.norm(pixels - true.keypoints[theirs], axis=2)
    apart[true.keypoint_states[theirs] != KeypointVisibility.VISIBLE] = np.nan
    seen = np.isfinite(apart).any(axis=1)
    mean = np.nanmean(apart[seen], axis=1)
    return np.sqrt((off**2).mean(axis=1)), mean, mean / true.height[theirs][seen]


def rows_at(frames: Array, ids: Array, at_frames: Array, at_ids: Array) -> Array:
    """The rows of a table that stand in given frames and have given ids."""
    keys = zip(frames.tolist(), ids.tolist(), strict=True)
    place = {key: row for row, key in enumerate(keys)}
    wanted = zip(at_frames.tolist(), at_ids.tolist(), strict=True)
    return np.array([place[key] for key in wanted], dtype=np.int64)


def keypoints_of(cuboids: Cuboids, shape: Array, model: CarModel, camera: Camera) -> Array:
    """Where the keypoints of cars with these cuboids and coefficients are in the image, px."""
    stretch = cuboids.size / model.size(shape, np.ones(len(shape)))
    x, y, z = (model.basis.shape(shape) * stretch[:, None]).transpose(2, 0, 1)
    c, s = np.cos(cuboids.yaw)[:, None], np.sin(cuboids.yaw)[:, None]
    road = np.stack([c * x + s * z, y, c * z - s * x], axis=2) + cuboids.base[:, None]
    return camera.project(transform(invert(camera.T_road_cam), road))


def row_of(
    what: tuple[str, str],
    factor: float | None,
    parts: list[tuple[CuboidErrors, Array, Array, Array]],
) -> Row:
    """The medians over the rows of several runs."""
    errors = CuboidErrors.concatenate([part[0] for part in parts])
    shape, pixels, shares = (np.concatenate([part[n] for part in parts]) for n in (1, 2, 3))
    numbers = errors.numbers()
    lengths = (numbers[f"{side}_error"] for side in ("length", "height", "width"))
    cells = (
        numbers["centre_median"], numbers["within_2m"], np.degrees(median(errors.heading)),
        numbers["heading_over_30"], numbers["heading_over_90"], *lengths, median(shape),
        median(pixels), 100.0 * median(shares),
    )  # fmt: skip
    plain: list[Cell] = [None if np.isnan(cell) else float(cell) for cell in cells]
    return (*what, "none" if factor is None else f"noise x {factor:g}", len(errors), *plain)


if __name__ == "__main__":
    main()

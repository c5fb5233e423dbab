"""Boxes of one's own from cameras of many kinds: scores of `mot-sim track --boxes` on made drives.

    python -m benchmarks.cameras [--seeds 1] [--seconds 15]

A made street (a made intersection for the camera on a mast, which stands) is seen by each camera,
at its frame rate, with the made detector; boxes, camera file and poses are written as files,
tracked by the command, and the results scored against the truth. `mot-sim calibrate-camera` finds
height and pitch from the same boxes. About five minutes.
"""

import argparse
import logging
import tempfile
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path

import numpy as np
from numpy import ndarray as Array

from mot_sim import find_scene, record
from mot_sim.__main__ import main as mot_sim
from mot_sim.datasets import CameraFile, read_results, write_lines
from mot_sim.datasets.camera_estimate import estimate_camera
from mot_sim.datasets.camera_files import camera_lines
from mot_sim.datasets.distortion import Distortion
from mot_sim.datasets.recorded import DetectionLog
from mot_sim.metrics import evaluate
from mot_sim.simulation.episode import Episode
from mot_sim.simulation.rig import KITTI_IMAGE_SIZE, KITTI_K, Rig
from mot_sim.simulation.scene import record_scene_traffic
from mot_sim.simulation.traffic.recording import RecordedTraffic
from mot_sim.simulation.traffic.traffic_state import STEP_SECONDS
from tracker.errors import BadDetections
from tracker.types import Camera, Tracks


def pinhole(
    focal: float, centre: tuple[float, float], size: tuple[int, int], height: float, pitch: float
) -> Camera:
    """A camera at a height (m), pitched up (degrees)."""
    K = np.array([[focal, 0.0, centre[0]], [0.0, focal, centre[1]], [0.0, 0.0, 1.0]])
    return Camera.mounted(K, size, height, float(np.radians(pitch)))


KITTI = Camera.mounted(np.array(KITTI_K), KITTI_IMAGE_SIZE, 1.65)
WAYMO = pinhole(2060.0, (950.0, 640.0), (1920, 1280), 2.1, 0.0)
NUSCENES = pinhole(1266.0, (816.0, 491.0), (1600, 900), 1.5, 0.0)
DASH = pinhole(1050.0, (960.0, 540.0), (1920, 1080), 1.3, -3.0)
MAST = pinhole(900.0, (640.0, 360.0), (1280, 720), 9.0, -60.0)


@dataclass(frozen=True)
class Kind:
    """A camera, and what it watches."""

    described: CameraFile
    """The camera, its lens and frame rate."""
    scene: str = "street"
    """The name of a scene."""
    stands: bool = False
    """Whether the camera stays where the ego car of the scene is half way."""


KINDS = {
    "KITTI, 10 Hz": Kind(CameraFile(KITTI, 10.0)),
    "like Waymo's, 1920x1280, 10 Hz": Kind(CameraFile(WAYMO, 10.0)),
    "like nuScenes', 1600x900, 12 Hz": Kind(CameraFile(NUSCENES, 12.0)),
    "like nuScenes', 1600x900, 2 Hz": Kind(CameraFile(NUSCENES, 2.0)),
    "dash camera with a lens, 30 Hz": Kind(
        CameraFile(DASH, 30.0, Distortion(DASH, np.array([-0.3, 0.09, 0.001, -0.0005, 0.0])))
    ),
    "on a mast, 60 degrees down, 10 Hz": Kind(CameraFile(MAST, 10.0), "intersection", stands=True),
}


def resampled(traffic: RecordedTraffic, rate: float) -> RecordedTraffic:
    """The traffic at another frame rate, Hz: a state each, between two such interpolated."""
    steps = np.arange(0.0, len(traffic) - 1.0, 1.0 / (rate * STEP_SECONDS)).round(9)
    before = np.minimum(steps.astype(int), len(traffic) - 2)
    share = (steps - before)[:, None]

    def between(values: Array, periodic: bool = False) -> Array:
        change = values[before + 1] - values[before]
        if periodic:
            change = (change + np.pi) % (2.0 * np.pi) - np.pi
        near = np.where(share < 1e-6, 0.0, share * change)  # a car may be gone a state later
        return np.asarray(values[before] + near)

    present = traffic.present[before] & (traffic.present[before + 1] | (share < 1e-6))
    ego = between(traffic.ego)
    ego[:, 2] = between(traffic.ego[:, 2:], periodic=True)[:, 0]
    x, y, speed = (
        np.where(present, between(values), np.nan)
        for values in (traffic.x, traffic.y, traffic.speed)
    )
    heading = np.where(present, between(traffic.heading, periodic=True), np.nan)
    size = np.where(present[:, :, None], traffic.size[before], np.nan)
    return replace(
        traffic, present=present, x=x, y=y, heading=heading, speed=speed, size=size, ego=ego,
        ego_size=traffic.ego_size[before],
        z=None if traffic.z is None else traffic.z[before],
        crashed=None if traffic.crashed is None else traffic.crashed[before],
    )  # fmt: skip


def made(kind: Kind, seed: int, seconds: float) -> Episode:
    """A drive as the pinhole camera behind the lens sees it."""
    lens = kind.described.distortion
    camera = kind.described.camera if lens is None else lens.pinhole
    scene = find_scene(kind.scene, frames=round(seconds / STEP_SECONDS) + 1)
    traffic = resampled(record_scene_traffic(scene, seed), kind.described.frame_rate)
    if kind.stands:
        ego = np.tile(traffic.ego[len(traffic) // 2], (len(traffic), 1))
        traffic = replace(traffic, ego=ego)
    return record(replace(scene, rig=Rig(camera), frame_count=len(traffic)), seed, traffic)


def seen_through(kind: Kind, boxes: Array) -> Array:
    """Boxes as they are in the real image."""
    lens = kind.described.distortion
    return boxes if lens is None else lens.distort_boxes(boxes)


def tracked(kind: Kind, episode: Episode, folder: Path, with_poses: bool) -> Tracks:
    """The rows that the command gives, of files."""
    found = episode.log.detections
    boxes = seen_through(kind, found.boxes)
    area = (boxes[:, 2:] - boxes[:, :2]).min(axis=1) > 0.5
    rows = np.column_stack([episode.log.frames, boxes, found.scores])[area]
    times = rows[:, 0] / kind.described.frame_rate
    lines = [
        f"{int(row[0])},{time:.4f}," + ",".join(f"{value:.3f}" for value in row[1:])
        for row, time in zip(rows.tolist(), times.tolist(), strict=True)
    ]
    write_lines(folder / "drive.csv", ["frame,time,x_min,y_min,x_max,y_max,score", *lines])
    write_lines(folder / "camera.toml", camera_lines(kind.described))
    poses = np.asarray(episode.Ts_world_cam)[:, :3].reshape(-1, 12)
    write_lines(
        folder / "poses.txt", (" ".join(f"{v:.9g}" for v in pose) for pose in poses.tolist())
    )
    files = {"--boxes": "drive.csv", "--camera": "camera.toml"}
    files |= {"--ego": "poses.txt"} if with_poses else {}
    options = [word for name, file in files.items() for word in (name, str(folder / file))]
    out = folder / f"out{int(with_poses)}"
    with redirect_stdout(StringIO()):
        assert mot_sim(["track", *options, "--out", str(out)]) == 0
    return read_results(out / "drive.txt")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=15.0)
    arguments = parser.parse_args()
    logging.basicConfig(level=logging.ERROR)
    print("| camera | HOTA | MOTA | IDSW | without poses: HOTA | IDSW | height, m | pitch, deg |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for name, kind in KINDS.items():
        parts: dict[bool, dict[str, tuple[Tracks, Tracks, int]]] = {True: {}, False: {}}
        logs = []
        for seed in range(arguments.seeds):
            episode = made(kind, seed, arguments.seconds)
            truth = episode.truth.replaced(boxes=seen_through(kind, episode.truth.boxes))
            logs.append(DetectionLog(episode.log.frames, episode.log.detections))
            for with_poses, part in parts.items():
                with tempfile.TemporaryDirectory() as folder:
                    rows = tracked(kind, episode, Path(folder), with_poses)
                part[str(seed)] = (truth, rows, len(episode))
        known, unknown = (evaluate(part).combined for part in parts.values())
        try:
            found = estimate_camera(logs, episode.camera.K, episode.camera.image_size)
            height, pitch = found.half_widths[0], np.degrees(found.half_widths[1])
            mount = (
                f"{found.camera.height:.2f} ±{height:.2f} ({episode.camera.height:.2f}) "
                f"| {np.degrees(found.pitch):.1f} ±{pitch:.1f}"
            )
        except BadDetections as error:
            mount = f"{str(error).split(' ')[0]} cars | "
        print(
            f"| {name} | {100 * known['HOTA']:.1f} | {100 * known['MOTA']:.1f} "
            f"| {known['IDSW']:.0f} | {100 * unknown['HOTA']:.1f} | {unknown['IDSW']:.0f} "
            f"| {mount} |",
            flush=True,
        )


if __name__ == "__main__":
    main()

"""How fast frames are labelled and drawn, and whether the truth agrees with itself.

    python -m benchmarks.truth [--root KITTI] [--boxes] [--agreement] [--frames 60]
        [--update-baseline]

Twenty cars of the fleet ahead of a KITTI camera, replayed from recorded traffic. Machines differ
and are shared: the tasks are measured in turn, CPU seconds of one thread, and beside every
figure stands its ratio to a yardstick of the same run, the top view that highway-env draws of
its own `highway-v0` with 50 cars; then those that were kept (see `benchmarks.baseline`). --root:
the given sequences of a KITTI tree are re-enacted and compared with their labels. --boxes: the
boxes of fully visible cars against their pixels, scene by scene. --agreement: the two renderers
over every scene (needs the extra `gl`).
"""

import argparse
import os
import tempfile
import warnings

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

from collections.abc import Callable  # noqa: E402
from pathlib import Path  # noqa: E402
from statistics import median  # noqa: E402
from time import process_time  # noqa: E402

import cv2  # noqa: E402
import numpy as np  # noqa: E402

from benchmarks.agreement import agreement_table  # noqa: E402
from benchmarks.baseline import Ratios  # noqa: E402
from mot_sim.datasets.kitti import kitti_sequence  # noqa: E402
from mot_sim.simulation.cars import VehicleSampler  # noqa: E402
from mot_sim.simulation.episode import record  # noqa: E402
from mot_sim.simulation.episodes import EpisodeFiles, read_episode, record_episode  # noqa: E402
from mot_sim.simulation.registry import SCENES, find_scene  # noqa: E402
from mot_sim.simulation.renderers import View, find_renderer  # noqa: E402
from mot_sim.simulation.rig import Rig  # noqa: E402
from mot_sim.simulation.scene import Scene  # noqa: E402
from mot_sim.simulation.scene_meshes import SceneMeshes  # noqa: E402
from mot_sim.simulation.traffic import (  # noqa: E402
    Replay,
    Route,
    Script,
    Scripted,
    TrafficState,
    kitti_recording,
)
from mot_sim.simulation.truth import (  # noqa: E402
    annotate,
    annotate_frame,
    boxes_in_image,
)
from tracker.geometry import box_iou  # noqa: E402

GIVEN = "0000 0002 0003 0004 0005 0007 0009 0011 0020"  # 0017 has no cars
LANES = (-5.25, -1.75, 1.75, 5.25)


def convoy(models: object) -> Scripted:
    """Four lanes of five cars ahead of us, at our speed; all of them in sight."""
    cars = [
        Script(
            Route([(11.0 + 13.0 * row + 3.0 * lane, y), (2000.0, y)]), [(0.0, 10.0 + 0.1 * lane)]
        )
        for row in range(5)
        for lane, y in enumerate(LANES)
    ]
    return Scripted(cars, Script(Route([(0.0, 0.0), (2000.0, 0.0)]), [(0.0, 10.0)]))


def top_view() -> Callable[[], object]:
    """highway-env's own picture of its own traffic."""
    warnings.filterwarnings("ignore")
    import gymnasium
    import highway_env

    gymnasium.register_envs(highway_env)
    env = gymnasium.make("highway-v0", render_mode="rgb_array", config={"vehicles_count": 50})
    env.reset(seed=0)
    return env.render


def speed_table(frames: int, ratios: Ratios) -> None:
    """Milliseconds of every task a frame, medians of rounds in turn."""
    cv2.setNumThreads(1)
    episode = record(Scene("convoy", convoy, frames), 0)
    stage, worlds = episode.scene_meshes, list(Replay(episode.traffic).recording.states)
    raster, seen = find_renderer("raster"), (episode.exact.visible > 0.0).sum() / frames
    faces = np.mean([len(mesh.faces) for mesh in stage.instances(worlds[0]).meshes])
    print(f"{seen:.1f} cars seen a frame, {faces:.0f} faces a car on average, 1242 x 375")

    def picture(world: TrafficState) -> object:
        return raster.render(View(stage.rig.camera, stage.instances(world)))

    draw = top_view()
    tasks: dict[str, Callable[[TrafficState], object]] = {
        "highway-env, top view": lambda _: draw(),
        "image, depth, ids": picture,
        "labels": lambda world: annotate_frame(world, stage, 0),
        "image, depth, ids, labels": lambda w: (picture(w), annotate_frame(w, stage, 0)),
    }
    times: dict[str, list[float]] = {name: [] for name in tasks}
    for world in [*worlds[:3], *worlds]:
        for name, task in tasks.items():
            start = process_time()
            task(world)
            times[name].append(process_time() - start)
    yardstick = median(times["highway-env, top view"][3:])
    print("task                          ms/frame   frames/s   x highway-env's top view")
    for name, all_ in times.items():
        one = median(all_[3:])
        if name != "highway-env, top view":
            ratios.add(name, one, yardstick)
        print(f"{name:28s}{1e3 * one:10.1f}{1.0 / one:11.0f}{yardstick / one:12.2f}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        record_episode(episode.scene, 0, EpisodeFiles(Path(folder), "0000"))
        start = process_time()
        read = read_episode(Path(folder), "0000")
        for frame in range(frames):
            read.exact.select(read.exact.tracks.frames == frame)
        one = (process_time() - start) / frames
        ratios.add("labels read from the episode", one, yardstick)
        print(f"{'labels read from the episode':28s}{1e3 * one:10.1f}{1.0 / one:11.0f}"
              f"{yardstick / one:12.2f}")  # fmt: skip


def replay_table(root: Path, names: list[str]) -> None:
    """Labelled drives, re-enacted: unoccluded cars against their labels."""
    print("\nunoccluded cars, median IoU with the label: whole ones    truncated ones"
          "\nsequence   rows    3D off by           cuboid      mesh   number    cuboid      mesh"
          )  # fmt: skip
    for name in names:
        drive = kitti_sequence(root, name, detections=None)
        labels = drive.truth
        assert labels is not None
        assert labels.kinds is not None
        recording = kitti_recording(drive)
        stage = SceneMeshes(VehicleSampler().sample(recording, 0), Rig(drive.camera))
        truth = annotate(recording.states, stage).truth
        labels = labels.select(np.isin(labels.kinds, ["Car", "Van"]))
        keys = [tracks.frames * 100_000 + tracks.ids for tracks in (labels, truth.tracks)]
        _, ours, theirs = np.intersect1d(*keys, return_indices=True)
        labels, drawn = labels.select(ours), truth.tracks.select(theirs)
        one, other = labels.cuboids, drawn.cuboids
        assert one is not None
        assert other is not None
        off = max(np.abs(one.base - other.base).max(), np.abs(one.size - other.size).max())
        assert labels.truncation is not None
        cuboid = box_iou(boxes_in_image(other, drive.camera), labels.boxes)
        mesh = box_iou(drawn.boxes, labels.boxes)
        whole, cut = (
            (labels.occlusion == 0) & truncated
            for truncated in (labels.truncation == 0, labels.truncation > 0)
        )
        print(f"{name:8s}{len(labels):8d}{off:12.1e} m{np.median(cuboid[whole]):16.3f}"
              f"{np.median(mesh[whole]):10.3f}{cut.sum():9d}{np.median(cuboid[cut]):10.3f}"
              f"{np.median(mesh[cut]):10.3f}", flush=True)  # fmt: skip


def box_table(names: list[str], frames: int) -> None:
    """Fully visible cars of two runs a scene: how far their boxes are from their visible pixels."""
    print("\nscene          car-frames   truncated   boxes within 2 px   5 px   farthest off, px")
    for name in names:
        off, cut = [], []
        for seed in (0, 1):
            truth = record(find_scene(name, frames=frames), seed).exact
            whole = truth.visible == 1.0
            assert truth.tracks.truncation is not None
            off.append(np.abs(truth.tracks.boxes - truth.visible_boxes)[whole].max(axis=1))
            cut.append(truth.tracks.truncation[whole] == 1)
        far, cuts = np.concatenate(off), np.concatenate(cut)
        print(f"{name:15s}{len(far):10d}{cuts.sum():12d}{100.0 * (far <= 2.0).mean():18.1f} %"
              f"{100.0 * (far <= 5.0).mean():7.1f} %{far.max():14.2f}", flush=True)  # fmt: skip


def main() -> None:
    """Print the tables that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, help="a KITTI tree with labels")
    parser.add_argument("--sequences", default=GIVEN)
    parser.add_argument("--boxes", action="store_true", help="of fully visible cars")
    parser.add_argument("--agreement", action="store_true", help="of the two renderers")
    parser.add_argument("--scenes", default=",".join(SCENES), help="of the last two")
    parser.add_argument("--frames", type=int, default=60)
    Ratios.add_option(parser)
    arguments = parser.parse_args()
    ratios = Ratios("truth")
    speed_table(arguments.frames, ratios)
    ratios.tell(arguments.update_baseline)
    if arguments.root:
        replay_table(arguments.root, arguments.sequences.split())
    if arguments.boxes:
        box_table(arguments.scenes.split(","), arguments.frames)
    if arguments.agreement:
        agreement_table(arguments.scenes.split(","))


if __name__ == "__main__":
    main()

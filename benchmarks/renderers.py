"""How fast views are drawn: frames a second on one core, with and without silhouettes.

    python -m benchmarks.renderers [--renderer mesh] [--growth] [--out FOLDER]

20 cars of 990 faces in four lanes, 1242 x 375 pixels: image, depth, instance and semantic ids.
Machines differ and are shared: beside every figure stands its ratio to a yardstick measured in
turn with it, the bare call of OpenCV's triangleRasterize on all faces of the same cars (OpenCV 5
has it).
"""

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import cv2
import numpy as np

from mot_sim.plotting import write_image
from mot_sim.simulation.renderers import NEAR_METRES, RENDERERS, View, find_renderer, silhouettes
from mot_sim.simulation.renderers.filling import fill
from mot_sim.simulation.renderers.triangles import Triangles
from tests.mot_sim.simulation.renderers.shapes import KITTI, street
from tracker.types import Camera

FRAMES = 60
Task = Callable[[View], object]


def world2cam(camera: Camera) -> np.ndarray:
    """From our camera's frame to OpenCV's (y up, z backwards), with K in it as a shear.

    With pixel centres at integers, and OpenCV's at halves, counted from below:
    x = z (2u + 1 - width) / height and y = z (height - 1 - 2v) / height.
    """
    width, height = camera.image_size
    A = np.zeros((4, 4))
    A[0, :3] = 2.0 * camera.K[0] / height
    A[0, 2] += (1.0 - width) / height
    A[1, :3] = -2.0 * camera.K[1] / height
    A[1, 2] += (height - 1.0) / height
    A[2, 2] = -1.0
    A[3, 3] = 1.0
    return A


def bare_opencv(view: View) -> None:
    """The yardstick: every face of every car, culled by OpenCV, nothing else."""
    places, meshes = view.instances.T_cam_object, view.instances.meshes
    corners = np.concatenate([
        (mesh.corners @ T[:3, :3].T + T[:3, 3]).reshape(-1, 3)
        for mesh, T in zip(meshes, places, strict=True)
    ]).astype(np.float32)  # fmt: skip
    width, height = view.camera.image_size
    image = np.zeros((height, width, 3), np.float32)
    depth = np.full((height, width), 200.0, np.float32)
    settings = cv2.TriangleRasterizeSettings()
    settings.setShadingType(cv2.RASTERIZE_SHADING_FLAT)
    numbers = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    A_opencv_cam, wide = world2cam(view.camera), 0.5 * np.pi
    cv2.triangleRasterize(
        corners, numbers, corners * 0.0, image, depth, A_opencv_cam, wide, 0.3, 200.0, settings
    )


def apart_from_opencv(view: View) -> tuple[int, int, int]:
    """Pixels with another triangle than OpenCV finds, with another object; of how many.

    Two triangles that share an edge may each take a pixel on it.
    """
    triangles = Triangles.of(view.instances, view.camera, NEAR_METRES)
    points = triangles.corners.reshape(-1, 3).astype(np.float32)
    width, height = view.camera.image_size
    numbers, depth = np.zeros((height, width, 3), np.float32), np.ones((height, width), np.float32)
    colours = np.zeros_like(points)
    colours[:, 0] = np.repeat(np.arange(1, len(triangles) + 1) / float(1 << 24), 3)
    settings = cv2.TriangleRasterizeSettings()
    settings.setCullingMode(cv2.RASTERIZE_CULLING_NONE)
    settings.setShadingType(cv2.RASTERIZE_SHADING_FLAT)
    settings.setGlCompatibleMode(cv2.RASTERIZE_COMPAT_INVDEPTH)
    depths = triangles.corners[..., 2].min() * 0.999, triangles.corners[..., 2].max() * 1.001
    rows = np.arange(len(points), dtype=np.int32).reshape(-1, 3)
    drawing = world2cam(view.camera), 0.5 * np.pi, *depths, settings
    cv2.triangleRasterize(points, rows, colours, numbers, depth, *drawing)
    theirs = np.round(numbers[..., 0] * float(1 << 24)).astype(np.int64)
    ours = fill(triangles, view.camera).numbers
    objects = np.concatenate(([-1], triangles.objects))
    others = np.count_nonzero(objects[ours] != objects[theirs])
    return np.count_nonzero(ours != theirs), others, ours.size


def measure(tasks: dict[str, Task], views: list[View]) -> dict[str, tuple[float, float]]:
    """Milliseconds a frame of each task, taken in turn: CPU time and wall time, medians."""
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in tasks}
    for view in views:
        for name, task in tasks.items():
            cpu, wall = process_time(), perf_counter()
            task(view)
            times[name].append((process_time() - cpu, perf_counter() - wall))
    return {
        name: (1e3 * median(cpu for cpu, _ in all_), 1e3 * median(wall for _, wall in all_))
        for name, all_ in times.items()
    }


def grown(scale: float) -> Camera:
    """KITTI's camera with so many times the pixels along each side."""
    K = np.diag((scale, scale, 1.0)) @ KITTI.K
    width, height = KITTI.image_size
    return replace(KITTI, K=K, image_size=(round(scale * width), round(scale * height)))


def growth(frames: int) -> None:
    """Print how image and labels' counts grow with cars and with pixels, CPU ms, medians."""
    renderer, yard = find_renderer("raster"), street()
    print("cars   image size    image ms   counts ms   x yardstick")
    for cars, scale in ((5, 1.0), (10, 1.0), (20, 1.0), (40, 1.0), (20, 0.5), (20, 2.0)):
        camera = grown(scale)
        views = [street(camera, cars, seed) for seed in range(frames)]
        tasks: dict[str, Task] = {
            "yard": lambda _: bare_opencv(yard), "image": renderer.render, "counts": silhouettes
        }  # fmt: skip
        times = measure(tasks, views[:1] + views)
        yardstick, image, counts = (times[name][0] for name in tasks)
        size = "{} x {}".format(*camera.image_size)
        print(f"{cars:4d}   {size:11s}{image:11.1f}{counts:12.1f}"
              f"{image / yardstick:9.2f} {counts / yardstick:.2f}", flush=True)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--renderer", default="raster", choices=sorted(RENDERERS))
    parser.add_argument("--growth", action="store_true", help="with cars and with pixels")
    parser.add_argument("--out", type=Path, help="a folder for one of the frames")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    renderer = find_renderer(arguments.renderer)
    views = [street(seed=seed) for seed in range(FRAMES)]
    drawn = [renderer.render(view) for view in views[:2]]  # warm
    if arguments.out:
        arguments.out.mkdir(parents=True, exist_ok=True)
        write_image(arguments.out / f"{arguments.renderer}.png", drawn[0].image)
    seen = int((silhouettes(views[0]).visible > 0).sum())
    tasks: dict[str, Task] = {
        "bare triangleRasterize": bare_opencv,
        arguments.renderer: renderer.render,
        f"{arguments.renderer} + silhouettes": lambda view: (
            renderer.render(view),
            silhouettes(view),
        ),
    }
    times = measure(tasks, views)
    yardstick = times["bare triangleRasterize"][0]
    width, height = KITTI.image_size
    one, other, of = np.sum([apart_from_opencv(view) for view in views], axis=0).tolist()
    print(f"{one} of {of} pixels show another triangle than OpenCV's, {other} another object")
    print(f"{width} x {height}, {seen} of {len(views[0].instances)} cars seen, {FRAMES} frames")
    print("task                      CPU ms   wall ms   frames/CPU s   x yardstick")
    for name, (cpu, wall) in times.items():
        print(f"{name:24s} {cpu:7.1f} {wall:9.1f} {1e3 / cpu:14.0f} {cpu / yardstick:13.1f}")

    if arguments.growth:
        growth(8)


if __name__ == "__main__":
    main()

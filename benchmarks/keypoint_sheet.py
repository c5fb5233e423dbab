"""A picture of keypoints over rendered and real cars. Called by `benchmarks.keypoints`."""

from pathlib import Path

import cv2
import numpy as np
from numpy import ndarray as Array

from benchmarks.keypoint_real import CLIPS, NEAR, bgr_of, pictures
from mot_sim.datasets import kitti_sequence
from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.augmentation import AugmentedCrops
from tracker.shape import (
    KEYPOINTS_36,
    Hourglass,
    ShapeFit,
    cut_crops,
    decode,
    to_shares,
    windows_of,
)

TILE, COLUMNS = 192, 10  # pixels; tiles in a row
CARS_A_CLIP = 30
LEFT, RIGHT, TRUE = (80, 160, 255), (255, 200, 40), (90, 255, 60)  # BGR
LEAST = 0.2  # confidence from which a point is drawn


def tile(crop: Array, found: Array, words: str, truth: Array | None = None) -> Array:
    """A crop with its keypoints: left ones orange, right ones blue, true ones green rings."""
    canvas = cv2.resize(crop, (TILE, TILE), interpolation=cv2.INTER_LINEAR)
    for point in [] if truth is None else (truth * TILE).round().astype(int).tolist():
        cv2.circle(canvas, tuple(point), 4, TRUE, 1, cv2.LINE_AA)
    for row, (x, y, confidence) in enumerate(found.tolist()):
        if confidence >= LEAST:
            colour = LEFT if row < len(KEYPOINTS_36) // 2 else RIGHT
            place = (round(x * TILE), round(y * TILE))
            cv2.circle(canvas, place, 1 + round(2 * confidence), colour, -1, cv2.LINE_AA)
    cv2.putText(canvas, words, (3, 12), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (255,) * 3, 1, cv2.LINE_AA)
    return canvas


def rendered_tiles(hourglass: Hourglass, shown: AugmentedCrops) -> list[Array]:
    """Crops of renders."""
    found = decode(hourglass.run(shown.images)[0])
    return [
        tile(image, points, "", truth[states == KeypointVisibility.VISIBLE])
        for image, points, truth, states in zip(
            shown.images, found, shown.keypoints, shown.states, strict=True
        )
    ]


def real_tiles(hourglass: Hourglass, root: Path) -> list[Array]:
    """Cars of the clips, evenly over time, with how far the fit's yaw is off."""
    tiles = []
    for name in CLIPS:
        sequence = kitti_sequence(root, name, detections=None)
        folder, truth = pictures(root, sequence), sequence.truth
        assert truth is not None
        assert truth.cuboids is not None
        assert truth.occlusion is not None
        there = np.isin(truth.frames, list(folder.paths)) & np.isin(truth.kinds, ["Car", "Van"])
        there &= (truth.occlusion <= 1) & (truth.cuboids.base[:, 2] < 1.5 * NEAR)
        rows = np.flatnonzero(there)
        for row in rows[:: max(len(rows) // CARS_A_CLIP, 1)]:
            one = truth.select(np.array([row]))
            assert one.cuboids is not None
            image, windows = bgr_of(folder, int(one.frames[0])), windows_of(one.boxes)
            seen = hourglass(image, one.boxes).keypoints
            fitted = ShapeFit()(seen, sequence.camera, 0.05 * (one.boxes[:, 2:] - one.boxes[:, :2]))
            off = np.degrees(np.angle(np.exp(1j * (fitted.yaw - one.cuboids.yaw))))[0]
            shares = np.dstack((to_shares(seen[:, :, :2], windows), seen[:, :, 2:]))[0]
            words = f"{name}/{one.frames[0]} {off:.0f}{'' if fitted.trusted[0] else '?'}"
            tiles.append(tile(cut_crops(image, windows)[0], shares, words))
    return tiles


def sheet(tiles: list[Array]) -> Array:
    """All tiles in rows, RGB."""
    tiles = tiles + [np.zeros_like(tiles[0])] * (-len(tiles) % COLUMNS)
    rows = [np.hstack(tiles[row : row + COLUMNS]) for row in range(0, len(tiles), COLUMNS)]
    return np.ascontiguousarray(np.vstack(rows)[:, :, ::-1])

"""Small worlds of cuboids to score: cars side by side ahead of the camera."""

import numpy as np

from tracker.types import Cuboids, Tracks

SIZE = (4.0, 1.5, 2.0)  # length, height, width
AHEAD = -np.pi / 2


def cuboids(rows: list[tuple[float, ...]]) -> Cuboids:
    """Cuboids of rows (x, z[, yaw[, length, height, width]]) on the road."""
    whole = [(*row, *(AHEAD, *SIZE)[len(row) - 2 :]) for row in rows]
    table = np.array(whole, dtype=float).reshape(-1, 6)
    base = np.column_stack([table[:, 0], np.full(len(table), 1.65), table[:, 1]])
    return Cuboids(base, table[:, 2], table[:, 3:])


def scene(
    rows: list[tuple], kinds: list[str] | None = None, scores: list[float] | None = None,
    occlusion: list[int] | None = None, truncation: list[int] | None = None,
) -> Tracks:  # fmt: skip
    """Tracks of rows (frame, id, x, z[, yaw[, length, height, width]]); boxes 40 px high."""
    x = np.array([row[2] for row in rows], dtype=float)
    z = np.array([row[3] for row in rows], dtype=float)
    left = 600.0 + 700.0 * x / np.maximum(z, 1.0)
    low = np.full(len(rows), 200.0)
    return Tracks(
        np.array([row[0] for row in rows], dtype=np.int64),
        np.array([row[1] for row in rows], dtype=np.int64),
        np.column_stack([left, low - 40.0, left + 50.0, low]).reshape(-1, 4),
        None if scores is None else np.array(scores, dtype=float),
        None if kinds is None else np.array(kinds, dtype="U12"),
        None if truncation is None else np.array(truncation, dtype=np.int64),
        None if occlusion is None else np.array(occlusion, dtype=np.int64),
        cuboids([row[2:] for row in rows]),
    )


def two_cars(frames: int = 5, yaw: float = AHEAD) -> list[tuple]:
    """Cars 0 and 1, 8 m apart, that drive ahead of us, in the order of frames."""
    return [(f, car, 8.0 * car - 4.0, 15.0 + f, yaw) for f in range(frames) for car in (0, 1)]

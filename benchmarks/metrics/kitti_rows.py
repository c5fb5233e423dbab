"""KITTI's rows as text: read for the comparison, written so that no digit is lost.

To be replaced by `mot_sim.datasets.kitti` (reading); its writer keeps six decimals, this all.
"""

from pathlib import Path

import numpy as np

from tracker.types import Tracks

# Frames of the 21 training sequences, 0000 to 0020.
FRAME_COUNTS = (
    154, 447, 233, 144, 314, 297, 270, 800, 390, 803, 294,
    373, 78, 340, 106, 376, 209, 145, 339, 1059, 837,
)  # fmt: skip


def read_rows(path: Path) -> Tracks:
    """The rows of a label or result file: frame, id, kind, truncation, occlusion and box."""
    rows = [line.split() for line in path.read_text().splitlines()]
    columns = list(zip(*rows, strict=False)) or [()] * 10
    return Tracks(
        np.array(columns[0], dtype=np.int64),
        np.array(columns[1], dtype=np.int64),
        np.array(columns[6:10], dtype=float).reshape(4, -1).T.copy(),
        kinds=np.array(columns[2], dtype="U12"),
        truncation=np.array(columns[3], dtype=float).astype(np.int64),
        occlusion=np.array(columns[4], dtype=float).astype(np.int64),
    )


def write_rows(tracks: Tracks, path: Path, score: bool) -> None:
    """Write rows with every digit of the boxes; `score` adds the 18th column of results."""
    lines = []
    for row in range(len(tracks)):
        levels = [-1, -1]
        if tracks.truncation is not None and tracks.occlusion is not None:
            levels = [tracks.truncation[row], tracks.occlusion[row]]
        kind = "Car" if tracks.kinds is None else tracks.kinds[row]
        box = " ".join(repr(float(value)) for value in tracks.boxes[row])
        lines.append(
            f"{tracks.frames[row]} {tracks.ids[row]} {kind} {levels[0]} {levels[1]} -10 {box} "
            f"-1 -1 -1 -1000 -1000 -1000 -10{' 1.0' if score else ''}\n"
        )
    path.write_text("".join(lines))

"""KITTI's rows as text, with every digit of the boxes.

`mot_sim.datasets` keeps six decimals, as KITTI does; a comparison of metrics needs all of them.
"""

from pathlib import Path

from tracker.types import Tracks


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

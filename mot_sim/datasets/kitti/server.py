"""The archive that KITTI's evaluation server takes: results of all its testing sequences."""

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path

from mot_sim.datasets.kitti.labels import RESULT_COLUMNS, read_results
from mot_sim.files.text import read_text
from mot_sim.files.writing import write_bytes
from tracker.errors import BadConfig, BadFile, DatasetNotFound

# Frames of the 29 testing sequences (KITTI tracking benchmark).
TESTING_FRAMES = (
    465, 147, 243, 257, 421, 809, 114, 215, 165, 349, 1176, 774, 694, 152, 850,
    701, 510, 305, 180, 404, 173, 203, 436, 430, 316, 176, 170, 85, 175,
)  # fmt: skip
# The same results give the same archive.
WHEN = (1980, 1, 1, 0, 0, 0)


def write_server_archive(results: Mapping[str, Path], out: Path) -> None:
    """Write `out`, a zip of 0000.txt ... 0028.txt, after checking what the server would refuse.

    results: the result files by sequence. Raises DatasetNotFound for sequences without results,
    BadConfig for what is none of the testing split or an archive not named .zip, BadFile for rows
    without a score, of no class, and beyond the end of their sequence.
    """
    names = [f"{number:04d}" for number in range(len(TESTING_FRAMES))]
    missing = [name for name in names if name not in results]
    if missing:
        raise DatasetNotFound(
            f"no results for {', '.join(missing)}: the server takes all {len(names)} testing "
            "sequences; where nothing was tracked, give an empty file"
        )
    others = sorted(set(results) - set(names))
    if others:
        raise BadConfig(f"{results[others[0]]}: the testing split has {names[0]}..{names[-1]} only")
    if out.suffix != ".zip":
        raise BadConfig(f"{out}: name the archive .zip")
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, frame_count in zip(names, TESTING_FRAMES, strict=True):
            text = read_text(results[name])
            read_results(results[name], frame_count=frame_count)
            fields = text.split("\n", 1)[0].split()
            if fields and len(fields) != len(RESULT_COLUMNS):
                raise BadFile(
                    f"{results[name]}:1: {len(fields)} values; the server wants "
                    f"{len(RESULT_COLUMNS)}, the last of them the score"
                )
            archive.writestr(zipfile.ZipInfo(f"{name}.txt", WHEN), text)
    write_bytes(out, packed.getvalue())

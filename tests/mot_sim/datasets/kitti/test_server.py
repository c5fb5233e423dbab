"""The archive for KITTI's server: complete, or refused by name."""

import zipfile
from pathlib import Path

import pytest

from mot_sim.datasets.kitti.server import TESTING_FRAMES, write_server_archive
from tests.mot_sim.datasets.conftest import write
from tracker.errors import BadConfig, BadFile, DatasetNotFound

ROW = "{} 1 Car -1 -1 -10 100 150 180 200 -1 -1 -1 -1000 -1000 -1000 -10 0.9\n"


@pytest.fixture
def results(tmp_path: Path) -> dict[str, Path]:
    """A row in the last frame of every testing sequence but the first, which is empty."""
    return {
        f"{number:04d}": write(
            tmp_path / "out" / f"{number:04d}.txt", ROW.format(count - 1) if number else ""
        )
        for number, count in enumerate(TESTING_FRAMES)
    }


def test_the_archive_holds_every_sequence_and_is_the_same_twice(results, tmp_path: Path) -> None:
    for name in ("a.zip", "b.zip"):
        write_server_archive(results, tmp_path / name)
    assert (tmp_path / "a.zip").read_bytes() == (tmp_path / "b.zip").read_bytes()
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        assert archive.namelist() == [f"{number:04d}.txt" for number in range(29)]
        assert archive.read("0005.txt").decode() == ROW.format(808)


def test_what_the_server_would_refuse_is_named(results, tmp_path: Path) -> None:
    out = tmp_path / "a.zip"
    with pytest.raises(BadConfig, match=r"name the archive \.zip"):
        write_server_archive(results, tmp_path / "a.tar")
    short = {name: path for name, path in results.items() if name != "0007"}
    with pytest.raises(DatasetNotFound, match="no results for 0007: the server takes all 29"):
        write_server_archive(short, out)
    with pytest.raises(BadConfig, match=r"the testing split has 0000\.\.0028 only"):
        write_server_archive(results | {"0029": results["0003"]}, out)
    for text, message in {
        ROW.format(0).rsplit(" ", 1)[0] + "\n": "0003.txt:1: 17 values; the server wants 18",
        ROW.format(TESTING_FRAMES[3]): "0003.txt:1: frame beyond the sequence",
        ROW.format(0).replace("Car", "Lorry"): "0003.txt:1: no class of KITTI: type Lorry",
    }.items():
        write(results["0003"], text)
        with pytest.raises(BadFile, match=message):
            write_server_archive(results, out)
    assert not out.exists()

"""`mot-sim calibrate-look`: the door to the fit."""

from pathlib import Path

import pytest

from mot_sim.__main__ import main
from mot_sim.plotting import write_image
from mot_sim.simulation.camera_looks import find_camera_look, fitting
from mot_sim.simulation.look_frames import drawn_frames, photographs
from tracker.errors import BadConfig, DatasetNotFound

KITTI = find_camera_look("kitti")


@pytest.fixture
def photos(tmp_path: Path) -> Path:
    """Photographs: a scene at night by KITTI's look."""
    (tmp_path / "photos").mkdir()
    for number, each in enumerate(drawn_frames("street", [8], every=2, frames=4, weather="night")):
        write_image(tmp_path / "photos" / f"{number:06d}.png", each.developed(KITTI))
    return tmp_path / "photos"


def test_the_file_that_it_writes_is_a_look(
    photos: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(fitting, "MAX_FIT_STEPS", 1)
    out = tmp_path / "mine.toml"
    options = ["--photos", str(photos), "--scenes", "crossing", "--seeds", "1", "--out", str(out)]
    assert main(["calibrate-look", *options]) == 0
    look = find_camera_look(str(out))
    assert look.name == "mine"
    assert look.source == "mot-sim calibrate-look: crossing at noon, photographs of photos"
    assert "luma_std" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--photos", "away"], "away"),
        (["--look", "kity"], "Did you mean 'kitti'"),
        (["--seeds", "0"], "--seeds 0: give 1 or more"),
        (["--per-clip", "0"], "0 photographs of a folder"),
    ],
)
def test_what_is_wrong_is_told_in_a_line(
    options: list[str], message: str, photos: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["calibrate-look", "--photos", str(photos), *options]) == 2
    told = capsys.readouterr().err
    assert told.startswith("error: ")
    assert message in told


def test_photographs_are_spread_over_their_folder(photos: Path) -> None:
    assert len(photographs(photos, 5)) == len(list(photos.iterdir()))
    assert len(photographs(photos, 1)) == 1
    with pytest.raises(BadConfig, match="0 photographs"):
        photographs(photos, 0)
    with pytest.raises(DatasetNotFound):
        photographs(photos / "away", 3)

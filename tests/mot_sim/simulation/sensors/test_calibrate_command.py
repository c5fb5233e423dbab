"""`mot-sim calibrate` on KITTI: what is wrong is one line."""

from pathlib import Path

import pytest

from mot_sim.__main__ import main


@pytest.mark.kitti
@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--detections", "rcc"], "Did you mean 'rrc'"),
        (["--sequences", "0017"], "needs at least 500"),
        (["--plot", "fit.jpg"], "ends in .png"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(
    options: list[str], told: str, kitti_root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["calibrate", "--root", str(kitti_root), *options]) == 2
    assert told in capsys.readouterr().err

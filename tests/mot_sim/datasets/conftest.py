"""A KITTI tree of three frames, written by hand."""

from pathlib import Path

import pytest

# f = 100, centre (50, 20), and a fourth column of 6: camera 2 sits 6 cm left of camera 0.
CALIBRATION = """\
P0: 100 0 50 0 0 100 20 0 0 0 1 0
P2: 100 0 50 6 0 100 20 0 0 0 1 0
R_rect 1 0 0 0 1 0 0 0 1
Tr_velo_cam 0 -1 0 0 0 0 -1 0 1 0 0 0
Tr_imu_velo 1 0 0 0 0 1 0 0 0 0 1 0
"""
OXTS_ROW = "49.0 {lon} 100 0 0 0" + " 0" * 24 + "\n"
# 1e-5 degrees of longitude at 49 degrees north: 6378137 cos(49 deg) pi / 180 * 1e-5 metres.
STEP = 0.730322
LABELS = """\
0 -1 DontCare -1 -1 -10.000000 1.000000 2.000000 3.000000 4.000000 \
-1000.000000 -1000.000000 -1000.000000 -10.000000 -1.000000 -1.000000 -1.000000
0 7 Car 0 1 -1.600000 40.000000 10.000000 60.000000 30.000000 \
1.500000 1.600000 4.000000 1.000000 1.650000 20.000000 -1.550000
2 7 Car 0 0 -1.600000 41.000000 11.000000 61.000000 31.000000 \
1.500000 1.600000 4.000000 1.000000 1.650000 18.500000 3.141593
"""
DETECTIONS = "0,40,10,60,30,0.9\n2,41,11,61,31,0.8\n2,90,5,150,80,0.25\n"


@pytest.fixture
def tiny_tree(tmp_path: Path) -> Path:
    """The root of a tree with the training sequence 0030; its car drives straight east."""
    files = {
        "training/calib/0030.txt": CALIBRATION,
        "training/oxts/0030.txt": "".join(
            OXTS_ROW.format(lon=8.0 + 1e-5 * frame) for frame in range(3)
        ),
        "training/label_02/0030.txt": LABELS,
        "detections/rrc/0030.txt": DETECTIONS,
        **{
            f"odometry/{source}/0030.txt": "".join(
                f"1 0 0 0 0 1 0 0 0 0 1 {0.75 * frame}\n" for frame in range(3)
            )
            for source in ("orbslam3", "noisy")
        },
    }
    for name, text in files.items():
        write(tmp_path / name, text)
    return tmp_path


def write(path: Path, text: str) -> Path:
    """The path, after the text was written there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path

"""The detectors whose files a KITTI tree may hold, and the formats of those files."""

from mot_sim.datasets.detection_files import DetectionFormat

CORNERS = DetectionFormat(("frame", "x1", "y1", "x2", "y2", "score"), delimiter=",")
KITTI_ROWS = DetectionFormat(
    (
        "frame", "id", "type", "truncated", "occluded", "alpha", "x1", "y1", "x2", "y2",
        "h", "w", "l", "x", "y", "z", "rotation_y", "score",
    ),
    kind="Car",
)  # fmt: skip

DETECTORS: dict[str, DetectionFormat] = {
    "rrc": CORNERS,
    "permatrack": CORNERS,
    "degraded": CORNERS,
    # Its published files hold five boxes without area; type 2 is Car.
    "pointrcnn": DetectionFormat(
        (
            "frame", "type", "x1", "y1", "x2", "y2", "score",
            "h", "w", "l", "x", "y", "z", "rotation_y", "alpha",
        ),
        delimiter=",",
        kind=2.0,
        bad_boxes="drop",
    ),
    "regionlets": KITTI_ROWS,
    "kitti": KITTI_ROWS,
    "motchallenge": DetectionFormat(
        ("frame", "id", "left", "top", "width", "height", "score"),
        delimiter=",",
        first_frame=1,
        open_ended=True,
    ),
}  # fmt: skip

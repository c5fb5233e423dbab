"""The detectors whose files a KITTI tree may hold, and the formats of those files."""

from dataclasses import replace

from mot_sim.datasets.detection_files import DetectionFormat, ScoreMap
from tracker.types import KITTI_KINDS

CORNERS = DetectionFormat(("frame", "x1", "y1", "x2", "y2", "score"), delimiter=",")
RRC = replace(CORNERS, score_map=ScoreMap(0.22, 0.134))
PERMATRACK = replace(CORNERS, score_map=ScoreMap(0.54, 0.073))
KITTI_ROWS = DetectionFormat(
    (
        "frame", "id", "type", "truncated", "occluded", "alpha", "x1", "y1", "x2", "y2",
        "h", "w", "l", "x", "y", "z", "rotation_y", "score",
    ),
    kinds={kind: kind for kind in KITTI_KINDS},
    scored=False,  # labels may stand for a perfect detector
)  # fmt: skip
# Its published files hold five boxes without area; the types are AB3DMOT's.
POINTRCNN = DetectionFormat(
    (
        "frame", "type", "x1", "y1", "x2", "y2", "score",
        "h", "w", "l", "x", "y", "z", "rotation_y", "alpha",
    ),
    delimiter=",",
    kinds={1.0: "Pedestrian", 2.0: "Car", 3.0: "Cyclist"},
    bad_boxes="drop",
    score_map=ScoreMap(2.43, 1.24),
)  # fmt: skip
PEDESTRIAN = ("Pedestrian",)

DETECTORS: dict[str, DetectionFormat] = {
    "rrc": RRC,
    "permatrack": PERMATRACK,
    "degraded": CORNERS,
    "simulated": CORNERS,  # of an episode; scores are probabilities already
    "exact": CORNERS,  # its true boxes
    "pointrcnn": POINTRCNN,
    "rrc_pedestrian": replace(CORNERS, tracked=PEDESTRIAN, score_map=ScoreMap(0.655, 0.0823)),
    "pointrcnn_pedestrian": replace(
        POINTRCNN, tracked=PEDESTRIAN, score_map=ScoreMap(3.46, 0.817)
    ),
    # Two hundred boxes of one sequence: too few to fit a score map to.
    "regionlets": KITTI_ROWS,
    "kitti": KITTI_ROWS,
    "motchallenge": DetectionFormat(
        ("frame", "id", "left", "top", "width", "height", "score"),
        delimiter=",",
        first_frame=1,
        open_ended=True,
    ),
}  # fmt: skip

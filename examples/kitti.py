"""Track and score one sequence of KITTI.

Needs KITTI's tracking data: MOT_SIM_KITTI_ROOT names the folder that holds training/calib,
training/oxts, training/label_02 and detections/rrc. Without it the script says what is missing
and ends with exit code 2.
"""

import sys

from mot_sim import Tracker, evaluate_sequence, kitti_sequence, track_sequence
from tracker.errors import DatasetNotFound

try:
    sequence = kitti_sequence(None, "0005", detections="rrc", ego="oxts")
except DatasetNotFound as missing:
    print(missing, file=sys.stderr)
    sys.exit(2)

print(f"sequence {sequence.name}: {len(sequence)} frames, {len(sequence.truth)} labels")
tracks, counts = track_sequence(Tracker.default(sequence.camera), sequence)
scores = evaluate_sequence(sequence.truth, tracks, len(sequence))
print(f"HOTA {100 * scores['HOTA']:.2f}, MOTA {100 * scores['MOTA']:.2f}", end=", ")
print(f"{scores['IDSW']:.0f} identity switches, {scores['Frag']:.0f} fragmentations")

# Printed:
# sequence 0005: 297 frames, 2148 labels
# HOTA 90.16, MOTA 97.01, 0 identity switches, 2 fragmentations

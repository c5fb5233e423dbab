"""Track boxes of your own: arrays in, identities and places on the road out.

The tracker needs boxes with scores and a calibrated camera; odometry is optional. Here one car
drives ahead of us and another stands at the roadside. The detector misses the first one in frames
3 and 4; the tracker keeps its identity.
"""

import numpy as np

from mot_sim import Camera, Detections, Frame, Tracker

K = np.array([[721.5, 0.0, 609.6], [0.0, 721.5, 172.9], [0.0, 0.0, 1.0]])
camera = Camera.mounted(K, image_size=(1242, 375), height=1.65)  # metres above the road
tracker = Tracker.default(camera)

forward = np.eye(4)
forward[2, 3] = -0.8  # we drive 0.8 m per frame, so that what stands still comes nearer

for index in range(7):
    ahead = [600.0, 180.0, 640.0, 212.0]
    nearer = 1.0 / (25.0 - 0.8 * index)  # 1 / m: the parked car is 25 m away in frame 0
    parked = [
        609.6 - 3600.0 * nearer, 172.9 + 120.0 * nearer,
        609.6 - 2000.0 * nearer, 172.9 + 1190.0 * nearer,
    ]  # fmt: skip
    boxes, scores = [parked], [0.9]  # x_min, y_min, x_max, y_max in pixels
    if index not in (3, 4):
        boxes, scores = [ahead, *boxes], [0.95, *scores]
    frame = Frame(
        index,
        time=0.1 * index,  # seconds
        detections=Detections.of(boxes, scores),
        T_now_before=forward if index else None,  # None where the motion is not known
    )
    tracks = tracker.step(frame)
    cars = zip(tracks.ids, tracks.cuboids.base, strict=True)
    where = [f"car {track}: x {x:.1f} m, z {z:.1f} m" for track, (x, _, z) in cars]
    print(f"frame {index}:", "; ".join(where))  # x: to the right of the camera, z: ahead of it

# Printed:
# frame 0: car 0: x 0.5 m, z 35.6 m; car 1: x -4.2 m, z 27.6 m
# frame 1: car 0: x 0.5 m, z 35.3 m; car 1: x -4.2 m, z 26.8 m
# frame 2: car 0: x 0.5 m, z 35.0 m; car 1: x -4.2 m, z 26.0 m
# frame 3: car 0: x 0.4 m, z 34.3 m; car 1: x -4.2 m, z 25.2 m
# frame 4: car 0: x 0.4 m, z 33.6 m; car 1: x -4.2 m, z 24.4 m
# frame 5: car 0: x 0.4 m, z 33.9 m; car 1: x -4.2 m, z 23.5 m
# frame 6: car 0: x 0.4 m, z 33.8 m; car 1: x -4.3 m, z 22.7 m

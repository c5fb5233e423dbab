"""Looks of the camera: what its lens, exposure, tone curve and sensor make of a drawn frame.

look = find_camera_look("kitti")
image = develop(drawn.image, camera, look, seed=3, frame=0)
"""

from mot_sim.simulation.camera_looks.developing import compressed, develop
from mot_sim.simulation.camera_looks.look import (
    CAMERA_LOOKS,
    PLAIN,
    CameraLook,
    find_camera_look,
    look_lines,
    read_camera_look,
)

__all__ = [
    "CAMERA_LOOKS",
    "PLAIN",
    "CameraLook",
    "compressed",
    "develop",
    "find_camera_look",
    "look_lines",
    "read_camera_look",
]

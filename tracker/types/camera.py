"""The camera: intrinsics, image, and where it stands above the road."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.errors import BadCalibration
from tracker.geometry import (
    homogeneous,
    intrinsics_fault,
    invert,
    road_contact,
    rotation_x,
    rotation_z,
)
from tracker.types.validation import as_floats, as_number, as_rigid, as_whole_number

# Metres; on a bridge or a mast perhaps, but 165 are centimetres.
MAX_HEIGHT = 100.0


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera above a road plane."""

    K: Float[Array, "3 3"]
    """Intrinsics, px, invertible; pixel centres are at integers."""
    image_size: tuple[int, int]
    """Width and height of the image, px, > 0."""
    T_cam_road: Float[Array, "4 4"]
    """Rigid, from `road` (on the road under the camera: x right, y down its normal, z forward) to
    `cam` (x right, y down, z forward); it holds pitch, roll and height, > 0 and <= 100 m."""

    def __post_init__(self) -> None:
        """Converts array-likes; raises BadCalibration for what no camera has, and says why."""
        K = as_floats("K", self.K, BadCalibration)
        fault = intrinsics_fault(K)
        if fault is not None:
            raise BadCalibration(f"K is {fault}: {K.tolist()}")
        object.__setattr__(self, "K", K)
        object.__setattr__(self, "image_size", _image_size(self.image_size))
        T_cam_road = as_rigid("T_cam_road", self.T_cam_road, BadCalibration)
        object.__setattr__(self, "T_cam_road", T_cam_road)
        if not 0.0 < self.height <= MAX_HEIGHT:
            below = -MAX_HEIGHT <= self.height < 0.0
            raise BadCalibration(
                f"camera height {self.height:g} m: the camera must stand above the road, at most "
                f"{MAX_HEIGHT:g} m; "
                + ("is it T_road_cam? Give its inverse" if below else "give metres")
            )

    @classmethod
    def mounted(
        cls,
        K: Float[Array, "3 3"],
        image_size: tuple[int, int],
        height: float,
        pitch: float = 0.0,
        roll: float = 0.0,
    ) -> "Camera":
        """A camera `height` metres above the road; pitch > 0 looks up, roll > 0 leans right.

        pitch, roll: radians. Raises BadCalibration as the constructor does.
        """
        height = as_number("camera height", height, BadCalibration)
        pitch, roll = (
            as_number(name, angle, BadCalibration)
            for name, angle in (("pitch", pitch), ("roll", roll))
        )
        if max(abs(pitch), abs(roll)) > np.pi:
            raise BadCalibration(f"pitch {pitch:g}, roll {roll:g}: give radians, within +-3.14")
        R_road_cam = rotation_x(pitch) @ rotation_z(roll)
        T_road_cam = homogeneous(R_road_cam, np.array([0.0, -height, 0.0]))
        return cls(K, image_size, invert(T_road_cam))

    @cached_property
    def T_road_cam(self) -> Float[Array, "4 4"]:
        """From the camera's frame to the road's."""
        return invert(self.T_cam_road)

    @cached_property
    def road_normal(self) -> Float[Array, "3"]:
        """The downward unit normal of the road in `cam`; (0, 1, 0) for a level camera."""
        return self.T_cam_road[:3, 1].copy()

    @cached_property
    def height(self) -> float:
        """Metres from the road to the camera: the road is `road_normal . X = height`."""
        return float(self.T_cam_road[:3, 1] @ self.T_cam_road[:3, 3])

    @cached_property
    def K_inverse(self) -> Float[Array, "3 3"]:
        """From homogeneous pixels to viewing rays."""
        return np.linalg.inv(self.K)

    @cached_property
    def principal_point(self) -> Float[Array, "2"]:
        """The pixel that the camera looks at."""
        return self.K[:2, 2].copy()

    @cached_property
    def P_road(self) -> Float[Array, "3 4"]:
        """Projects homogeneous points of the road frame: K [R | t]."""
        P: Float[Array, "3 4"] = self.K.dot(self.T_cam_road[:3])
        return P

    @cached_property
    def P_road_centred(self) -> Float[Array, "3 4"]:
        """Projects homogeneous points of the road frame, pixels counted from the principal point.

        K [R | t] with f x in place of f x + c z: what is drawn to another depth keeps its side.
        """
        K_centred = self.K.copy()
        K_centred[:2, 2] = 0.0
        return K_centred @ self.T_cam_road[:3]

    def project(self, points_cam: Float[Array, "*n 3"]) -> Float[Array, "*n 2"]:
        """Where points of the camera frame appear, in pixels; NaN behind the camera."""
        homogeneous_pixels = points_cam @ self.K.T
        depth = homogeneous_pixels[..., 2:]
        in_front = depth > 1e-6
        return np.where(
            in_front, homogeneous_pixels[..., :2] / np.where(in_front, depth, 1), np.nan
        )

    @cached_property
    def A_road_pixel(self) -> Float[Array, "3 3"]:
        """R_road_cam K^-1: from homogeneous pixels to viewing rays in the road's axes."""
        return self.T_road_cam[:3, :3] @ self.K_inverse

    @cached_property
    def pixel_rays_road(self) -> tuple[Float[Array, "2 3"], Float[Array, "3"]]:
        """The same as columns: what a pixel adds to a ray, and the ray of pixel (0, 0)."""
        return self.A_road_pixel[:, :2].T.copy(), self.A_road_pixel[:, 2].copy()

    @cached_property
    def place_shift(self) -> Float[Array, "4 18"]:
        """How a small motion of the camera shifts points of the road frame.

        For a point X in the camera's frame and a motion (rho, phi) the shift is rho + phi x X.
        [X_road, 1] times this matrix, reshaped to (3, 6), is its Jacobian by (rho, phi).
        """
        X_cam = self.T_cam_road[:3].T  # [X_road, 1] @ X_cam is the point in the camera's frame
        jacobian = np.zeros((4, 3, 6))
        for row, axis in enumerate(self.T_road_cam[:3, :3]):
            jacobian[3, row, :3] = axis
            jacobian[:, row, 3:] = np.cross(X_cam, axis)  # axis . (phi x X) = phi . (X x axis)
        return jacobian.reshape(4, 18)

    @cached_property
    def road_shift(self) -> Float[Array, "4 12"]:
        """The same along road x and z alone: reshaped to (2, 6)."""
        return self.place_shift.reshape(4, 3, 6)[:, ::2].reshape(4, 12)

    @cached_property
    def far_corner(self) -> Float[Array, "4"]:
        """The centre of the last pixel, twice: what boxes are clipped to."""
        width, height = self.image_size
        return np.array([width - 1.0, height - 1.0, width - 1.0, height - 1.0])

    def clip_boxes(self, boxes: Float[Array, "*n 4"]) -> Float[Array, "*n 4"]:
        """The parts of boxes inside the image; without area where there is none."""
        return np.minimum(np.maximum(boxes, 0.0), self.far_corner)

    def rays(self, pixels: Float[Array, "*n 2"]) -> Float[Array, "*n 3"]:
        """K^-1 x: the viewing rays of pixels in camera coordinates, with depth 1."""
        return pixels @ self.K_inverse[:, :2].T + self.K_inverse[:, 2]

    def rays_road(self, pixels: Float[Array, "*n 2"]) -> Float[Array, "*n 3"]:
        """The same rays in the road's axes (not its origin)."""
        per_pixel, at_origin = self.pixel_rays_road
        return pixels.dot(per_pixel) + at_origin

    def touch_road(self, pixels: Float[Array, "n 2"]) -> Float[Array, "n 3"]:
        """Where the rays through the pixels meet the road, in camera coordinates (eq. 2).

        Rays at or above the horizon never meet it and give NaN.
        """
        return road_contact(self.rays_road(pixels), self.height) @ self.T_road_cam[:3, :3]


def _image_size(given: object) -> tuple[int, int]:
    """Width and height as two whole numbers above 0; else BadCalibration."""
    cure = "give width and height in pixels"
    width: object
    height: object
    try:
        width, height = given  # type: ignore[misc]
    except (TypeError, ValueError):
        raise BadCalibration(f"image size {given!r}: {cure}") from None
    size = (
        as_whole_number("image width", width, BadCalibration),
        as_whole_number("image height", height, BadCalibration),
    )
    if min(size) <= 0:
        raise BadCalibration(f"image size {size}: {cure}")
    return size

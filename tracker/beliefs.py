"""Where we think objects are: detections lifted through the road.

Sharma et al., ICRA 2018: `Lift` is phi(pi_G^-1(.), s) of eqs. 2-4.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from tracker.geometry.ground import MIN_DIP
from tracker.kernels import Kernel
from tracker.types import Camera, Cuboids, Detections
from tracker.types.embedding import Embedding
from tracker.types.packed import NO_INTS, ColumnBlock, Packed, PackedRows, read_only
from tracker.types.rows import RowIndex
from tracker.types.shape_pose import ShapePose

# Length, height, width of the median car among KITTI's labels (ten sequences), metres.
MEAN_CAR = (3.9, 1.5, 1.63)
# Nearest depth of anything in front of the camera, metres.
MIN_DEPTH = 1.0
# Beyond this a road contact has no depth (one pixel is 20 m at KITTI's focal length), metres.
MAX_CONTACT_DEPTH = 150.0
# A box whose lower edge is this near to the image's (pixels) is cut by it: no road contact.
BORDER_PIXELS = 2.0
# Boxes times this are the pixels of their bottom centres.
BOTTOM_CENTRE = np.array([[0.5, 0.0], [0.0, 0.0], [0.5, 0.0], [0.0, 1.0]])
LIMITS = np.array([MIN_DIP, MIN_DEPTH, MAX_CONTACT_DEPTH])
LIFT_BOXES = Kernel("tracker.kernels.lifting", "lift_boxes")
KEEP_MEASURED = Kernel("tracker.kernels.writing", "keep_measured")
NO_YAWS = np.zeros(0)
STRETCH = Kernel("tracker.kernels.pairing", "stretch")


@dataclass(frozen=True, eq=False)
class Beliefs(PackedRows):
    """Objects in the road frame of one moment, with their uncertainty; one per row."""

    cuboids: Cuboids
    """Where they stand, in the road frame."""
    velocity: Float[Array, "n 2"]
    """Of the base along road x and z, m/s; 0: unknown."""
    cov: Float[Array, "n 4 4"]
    """Covariance of (x, z, velocity x, velocity z) in the road frame, m and m/s."""
    boxes: Float[Array, "n 4"]
    """x_min, y_min, x_max, y_max in the image of that moment, px, not clipped; as detected (after
    `Lift`) or as predicted (after ego-motion)."""
    shape_pose: ShapePose | None = None
    """Shape and yaw as last measured; None where no detector gives them."""
    embedding: Embedding | None = None
    """Appearance as last measured; None where no detector gives it."""

    BLOCKS: ClassVar[Mapping[str, ColumnBlock]] = {
        "cuboids": ColumnBlock(0, 7, table=Cuboids),
        "velocity": ColumnBlock(7, 2, (2,)),
        "cov": ColumnBlock(9, 16, (4, 4)),
        "boxes": ColumnBlock(25, 4, (4,)),
    }

    @classmethod
    def empty(cls) -> "Beliefs":
        """No object."""
        return cls(Cuboids.empty(), np.zeros((0, 2)), np.zeros((0, 4, 4)), np.zeros((0, 4)))

    def updated(self, rows: RowIndex, others: "Beliefs") -> "Beliefs":
        """These beliefs with others in the given rows; rows that lack a cue are filled with NaN."""
        mine, theirs = alike((self, others))
        return super(Beliefs, mine).updated(rows, theirs)

    @classmethod
    def concatenate(cls, parts: Sequence["Beliefs"]) -> "Beliefs":
        """The rows of all parts; rows that lack a cue which others have are filled with NaN.

        A frame without detections has no columns of cues; that takes none from the other rows.
        """
        return super().concatenate(alike(parts))

    def region(self, sigmas: float) -> Cuboids:
        """The cuboids stretched by `sigmas` standard deviations along and across the car.

        The uncertainty is far longer than wide (it points along the viewing ray): it is taken
        in the car's own axes, so that the region stays a cuboid.
        """
        size = np.empty(self.cuboids.size.shape)
        STRETCH(self.cuboids.yaw, self.cuboids.size, self.cov, sigmas, size)
        return Cuboids(self.cuboids.base, self.cuboids.yaw, size)


NO_BELIEFS = Beliefs.empty()


def alike(parts: Sequence[Beliefs]) -> Sequence[Beliefs]:
    """The same beliefs; those that lack a cue which others have get NaN rows of it."""
    for cue in ("shape_pose", "embedding"):
        measured = [getattr(part, cue) for part in parts]
        known = [column for column in measured if column is not None]
        if known and len(known) < len(parts):
            parts = [
                part.replaced(**{cue: known[0].unknown(len(part))}) if column is None else part
                for part, column in zip(parts, measured, strict=True)
            ]
    return parts


@dataclass(frozen=True)
class Lift:
    """Back-projects boxes to beliefs on the road: eq. 2 with its linearised covariance."""

    edge_std: float = 0.03
    """Std of a box's bottom centre at score 1, share of the box's height; it doubles at score 0
    (sigma(s) of the paper). RRC's edges: 0.027-0.031; more: larger search areas."""
    pitch_std: float = 0.005
    """How much the camera nods from frame to frame, rad; what is constant shifts old and new alike.
    More: less certain depths."""
    height_std: float = 0.03
    """How much the camera heaves from frame to frame, metres; more: less certain depths."""
    car_size: tuple[float, float, float] = MEAN_CAR
    """Length, height and width where no detector measured them, metres."""
    car_size_std: float = 0.06
    """Std of the height in `car_size`, share of it; it limits the depth that a box's height tells.
    More: that depth weighs less."""
    yaw: float = -np.pi / 2
    """Yaw where no detector measured it, rad about road +y; -pi/2: along the road that the camera
    looks down."""
    speed_std: tuple[float, float] = (3.0, 8.0)
    """Std of the unknown velocity of a new belief, along road x and z, m/s; more: the second
    detection may lie farther away."""
    use_box_height: bool = False
    """Whether to fuse the depth that the box's height tells. Unlike the paper, which has eq. 2
    alone; a box whose bottom edge is no road contact is placed by its height in any case."""

    def __call__(self, detections: Detections, camera: Camera) -> Beliefs:
        """One belief a detection.

        The bottom centre of the box touches the road at the car's near face (eq. 2); the centre
        lies behind it, on the same ray, by half of the yawed extent. Where the bottom edge is no
        road contact (cut by the lower border, or above the horizon) the depth comes from the
        box's height, at most that of the border, and its std is half of it.
        """
        boxes, n = detections.boxes, len(detections)
        if n == 0:
            return NO_BELIEFS
        yaw, size, behind = self._stance(detections)
        floats = np.empty(29 * n)
        lowest = camera.image_size[1] - 1.0 - BORDER_PIXELS
        view = *camera.pixel_rays_road, camera.height, camera.K[1, 1], lowest
        noise = *self._noise, LIMITS, self.use_box_height
        LIFT_BOXES(boxes, detections.scores, yaw, size, behind, *view, *noise, floats)
        cues = {"shape_pose": ShapePose.of(detections), "embedding": Embedding.of(detections)}
        return Beliefs.of_packed(Packed(n, read_only(floats), NO_INTS), **cues)

    def measured_part(self, beliefs: Beliefs) -> Cuboids:
        """The cuboids, with NaN for sizes and headings that nothing measured."""
        (n, floats, _), pose = beliefs.packed, beliefs.shape_pose
        cuboids, yaws = np.empty(7 * n), NO_YAWS if pose is None else pose.yaw
        KEEP_MEASURED(floats, n, self._mean_car[1][0], yaws, cuboids)
        return Cuboids.of_packed(Packed(n, read_only(cuboids), NO_INTS))

    @cached_property
    def _noise(self) -> tuple[Float[Array, "4"], Float[Array, "2"]]:
        """Stds of edges, height, pitch and sizes; of the speed."""
        stds = self.edge_std, self.height_std, self.pitch_std, self.car_size_std
        return np.array(stds, float), np.array(self.speed_std, float)

    def _stance(
        self, detections: Detections
    ) -> tuple[Float[Array, " #n"], Float[Array, "#n 3"], Float[Array, " #n"]]:
        """Yaw, size, and how far the centre is behind the near face.

        As measured; where they are not (no column, or a NaN row), those of the mean car. One for
        all where nothing is measured.
        """
        n, yaw, size = len(detections), detections.yaw, detections.size
        if yaw is None and size is None:
            return self._mean_car
        mean_yaw, mean_size, _ = self._mean_car
        yaw = mean_yaw.repeat(n) if yaw is None else np.where(np.isnan(yaw), mean_yaw, yaw)
        size = mean_size.repeat(n, 0) if size is None else np.where(np.isnan(size), mean_size, size)
        return yaw, size, half_extent(yaw, size)

    @cached_property
    def _mean_car(self) -> tuple[Float[Array, "1"], Float[Array, "1 3"], Float[Array, "1"]]:
        """The stance of a car of which nothing is measured."""
        yaw, size = np.array([self.yaw], float), np.array([self.car_size], float)
        return yaw, size, half_extent(yaw, size)


def half_extent(yaw: Float[Array, " n"], size: Float[Array, "n 3"]) -> Float[Array, " n"]:
    """Half of what upright cuboids measure along the road's z, metres."""
    return 0.5 * (size[:, 0] * np.abs(np.sin(yaw)) + size[:, 2] * np.abs(np.cos(yaw)))

"""Metres from the road: how far the camera moved, read off the road's own pixels.

A pixel of the road now, with ray r, lies at X = h r / (n . r) (eq. 2 of Sharma et al., ICRA
2018), and was seen before where R^T (X - s d) projects to. The length s of the motion, and how
far the car's nose dips (the tilt of n), are those that make the two images alike there.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from jaxtyping import Bool, Float, Float32, UInt8
from numpy import ndarray as Array

from tracker.geometry import rotation_x
from tracker.types import Camera

MAX_ROUNDS = 6
CONVERGED_METRES = 1e-3  # metres: a step below a tenth of a length's error is the last
CONTRAST_WINDOW = (15, 15)  # pixels over which brightness and contrast are evened out
MIN_CONTRAST = np.float32(1.0)  # grey levels of contrast that are as much noise as texture
MIN_ROAD_PIXELS = 300  # pixels of the road that must be seen in both images


@dataclass(frozen=True, eq=False)
class Length:
    """How far the camera moved, read off the road."""

    metres: float
    """Along the given direction."""
    std: float
    """Its standard deviation, metres."""
    tilt: float
    """Of the road against the calibration, rad."""
    likeness: float
    """Correlation of the road's pixels in the two images, -1 to 1."""


@dataclass(frozen=True, eq=False)
class RoadScale:
    """Reads lengths off the part of the road right in front of the camera."""

    camera: Camera
    """The camera, with its height above the road."""
    far: float = 16.0
    """Metres ahead up to which the road is used; more: more pixels, less sharp ones."""
    half_width: float = 3.0
    """Metres to each side up to which the road is used; more: more pixels, and more kerbs."""
    spacing: int = 4
    """Px between the pixels that take part; more: less exact, less time."""
    tilt_std: float = 5e-3
    """How far a car's nose goes up and down on its springs, std in rad (KITTI: 0.3 degrees); more:
    a freer tilt, less certain lengths."""
    independent: float = 12.0
    """How many neighbouring pixels are one measurement; more: larger std of lengths."""
    least_likeness: float = 0.25
    """Least correlation for a length, -1 to 1; more: fewer frames are read."""

    @cached_property
    def pixels(self) -> Float[Array, "n 2"]:
        """Of the road in front, whole numbers."""
        width, height = self.camera.image_size
        grid = np.mgrid[4 : width - 4 : self.spacing, 4 : height - 4 : self.spacing]
        pixels = grid.reshape(2, -1).T.astype(float)
        road = self.camera.touch_road(pixels) @ self.camera.T_road_cam[:3, :3].T
        near = (np.abs(road[:, 0]) < self.half_width) & (road[:, 2] < self.far)
        return pixels[near & (road[:, 2] > 0.0)][:30_000]  # OpenCV's remap takes 32,767

    @cached_property
    def rays(self) -> Float[Array, "n 3"]:
        """Of those pixels."""
        return self.camera.rays(self.pixels)

    @cached_property
    def top(self) -> int:
        """The first row of the image that is looked at: some above the road's, which recedes."""
        return max(int(self.pixels[:, 1].min()) - 60, 0) if len(self.pixels) else 0

    def texture(self, grey: UInt8[Array, "h w"]) -> Float32[Array, "r w"]:
        """The rows from `top`, evened out: a shadow's edge must not outweigh the asphalt."""
        smooth = cv2.GaussianBlur(grey[self.top :], (0, 0), 1.0).astype(np.float32)
        fine = smooth - cv2.blur(smooth, CONTRAST_WINDOW)
        contrast = np.sqrt(np.maximum(cv2.blur(fine * fine, CONTRAST_WINDOW), 0.0))
        even: Float32[Array, "r w"] = 10.0 * fine / (contrast + MIN_CONTRAST)
        return even

    def __call__(
        self,
        before: Float32[Array, "r w"],
        now: Float32[Array, "r w"],
        free: Bool[Array, "h w"],
        R: Float[Array, "3 3"],
        direction: Float[Array, "3"],
        guesses: Float[Array, " k"],
    ) -> Length | None:
        """The length of a motion whose rotation and direction are known; None if unreadable.

        before, now: textures. free: what of the image may be road. guesses: lengths to start
        from, 0.1 m apart or less, for only the right one's surroundings lead to it.
        """
        v, u = self.pixels[:, 1].astype(int), self.pixels[:, 0].astype(int)
        seen = np.flatnonzero(free[v, u])
        if len(seen) < MIN_ROAD_PIXELS:
            return None
        wanted = now[v[seen] - self.top, u[seen]].astype(float)
        warp = _Warp(self, R, direction, self.rays[seen], wanted)
        rough = _Warp(self, R, direction, self.rays[seen[::4]], wanted[::4])
        likeness = [rough.likeness(before, float(guess)) for guess in guesses]
        if not np.isfinite(likeness).any():
            return None
        return warp.align(before, float(guesses[int(np.nanargmax(likeness))]))


@dataclass(frozen=True, eq=False)
class _Warp:
    """Road pixels of now, sought in the image before."""

    road: RoadScale
    R: Float[Array, "3 3"]
    direction: Float[Array, "3"]
    rays: Float[Array, "n 3"]
    wanted: Float[Array, " n"]

    def places(self, metres: float, tilt: float) -> Float[Array, "n 2"]:
        """Where the pixels were before; NaN behind the camera then."""
        return self._pixels(self._before(self._now(tilt)[0], metres))

    def slopes(self, metres: float, tilt: float) -> Float[Array, "n 2 2"]:
        """The derivatives of the places by metres and tilt."""
        X, normal = self._now(tilt)
        before = self._before(X, metres)
        turning = np.array([0.0, -normal[2], normal[1]])  # of the normal, as the tilt grows
        by_tilt = (X * (-(self.rays @ turning) / (self.rays @ normal))[:, None]) @ self.R
        by_metres = (-self.direction @ self.R)[None]
        depth, flat = before[:, 2:], before[:, :2] / before[:, 2:]
        focal = self.road.camera.K[:2, :2].T
        slopes = [(by[:, :2] - flat * by[:, 2:]) / depth @ focal for by in (by_metres, by_tilt)]
        return np.stack(slopes, axis=2)

    def _now(self, tilt: float) -> tuple[Float[Array, "n 3"], Float[Array, "3"]]:
        """The road's points in the camera's frame, and its normal."""
        camera = self.road.camera
        normal = rotation_x(tilt) @ camera.road_normal
        return self.rays * (camera.height / (self.rays @ normal))[:, None], normal

    def _before(self, X: Float[Array, "n 3"], metres: float) -> Float[Array, "n 3"]:
        """The points in the camera's frame before; NaN behind it."""
        before = (X - metres * self.direction) @ self.R
        before[before[:, 2] < 0.1] = np.nan
        return before

    def _pixels(self, points: Float[Array, "n 3"]) -> Float[Array, "n 2"]:
        K = self.road.camera.K
        return points[:, :2] / points[:, 2:] @ K[:2, :2].T + K[:2, 2]

    def sample(
        self, image: Float32[Array, "r w"], places: Float[Array, "n 2"]
    ) -> Float[Array, " n"]:
        """Values between pixels; NaN outside."""
        at = (places - (0.0, self.road.top)).astype(np.float32)
        values = cv2.remap(
            image, at[:, 0], at[:, 1], cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT, borderValue=float("nan"),
        )  # fmt: skip
        return values.reshape(-1).astype(float)

    def likeness(self, image: Float32[Array, "r w"], metres: float, tilt: float = 0.0) -> float:
        """The correlation with the image before; NaN where too little is seen in both."""
        found = self.sample(image, self.places(metres, tilt))
        both = np.isfinite(found)
        if both.sum() < MIN_ROAD_PIXELS / 4:
            return float("nan")
        a, b = found[both] - found[both].mean(), self.wanted[both] - self.wanted[both].mean()
        size = float(np.sqrt((a @ a) * (b @ b)))
        return float(a @ b) / size if size > 1e-6 else float("nan")

    def align(self, image: Float32[Array, "r w"], metres: float) -> Length | None:
        """Gauss and Newton from a first guess, Cauchy weights, the tilt held by its prior."""
        tilt = 0.0
        axes = ((1, 0), (0, 1))
        slopes = [cv2.Sobel(image, cv2.CV_32F, *axis, ksize=3, scale=0.125) for axis in axes]
        for _ in range(MAX_ROUNDS):
            places, by = self.places(metres, tilt), self.slopes(metres, tilt)
            misses = self.sample(image, places) - self.wanted
            slope = np.stack([self.sample(each, places) for each in slopes], axis=1)
            jacobian = (slope[:, :, None] * by).sum(axis=1)
            both = np.isfinite(misses) & np.isfinite(jacobian).all(axis=1)
            if both.sum() < MIN_ROAD_PIXELS:
                return None
            misses, jacobian = misses[both], jacobian[both]
            noise = 1.48 * float(np.median(np.abs(misses))) + 0.3
            weighted = jacobian * (1.0 / (1.0 + (misses / (2.0 * noise)) ** 2))[:, None]
            one = self.road.independent * noise**2
            curvature = jacobian.T @ weighted / one + 1e-6 * np.eye(2)
            curvature[1, 1] += self.road.tilt_std**-2
            pull = weighted.T @ misses / one + (0.0, tilt / self.road.tilt_std**2)
            step = -np.linalg.solve(curvature, pull)
            metres, tilt = metres + float(step[0]), tilt + float(step[1])
            if abs(step[0]) < CONVERGED_METRES:
                break
        likeness = self.likeness(image, metres, tilt)
        if not likeness >= self.road.least_likeness:
            return None
        std = float(np.sqrt(np.linalg.inv(curvature)[0, 0]))
        return Length(metres, std, tilt, likeness)

"""What surrounds the objects: a road seen from above, a sky, a sun."""

from dataclasses import dataclass, field
from functools import cache, cached_property

import cv2
import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray as Array

from tracker.errors import BadConfig

Colour = tuple[int, int, int]

ASPHALT_COLOUR: Colour = (92, 94, 98)
GRASS_COLOUR: Colour = (118, 132, 88)


PLAIN_TEXELS = 64  # texels along a plain road's sides
PLAIN_METRES = 2000.0  # metres


@dataclass(frozen=True, eq=False)
class Texture:
    """An RGB picture, made once and used in many frames."""

    pixels: UInt8[Array, "h w 3"]
    """RGB; row v, column u; at least one pixel."""

    def __post_init__(self) -> None:
        height, width = self.pixels.shape[:2]
        if min(height, width) == 0:
            raise BadConfig(f"a texture of {width} x {height} pixels: it needs some")

    @classmethod
    def of_rgba(cls, rgba: UInt8[Array, "h w 4"]) -> "Texture":
        """A picture that says itself where there is road: alpha 255, and 0 beside it."""
        texture = cls(rgba[..., :3])
        texture.__dict__["rgba"] = rgba
        return texture

    @property
    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self.pixels.shape[1], self.pixels.shape[0]

    @cached_property
    def rgba(self) -> UInt8[Array, "h w 4"]:
        """With a fourth channel, 255 on the road: OpenCV warps that twice as fast."""
        return cv2.cvtColor(self.pixels, cv2.COLOR_RGB2RGBA)


@cache
def _plain() -> Texture:
    return Texture(np.full((PLAIN_TEXELS, PLAIN_TEXELS, 3), ASPHALT_COLOUR, np.uint8))


def _plain_map() -> Float[Array, "3 3"]:
    """A plain texture around the camera."""
    scale, middle = PLAIN_TEXELS / PLAIN_METRES, 0.5 * (PLAIN_TEXELS - 1)
    return np.array([[scale, 0.0, middle], [0.0, scale, middle], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Level:
    """A finer picture of a part of the road plane."""

    texture: Texture
    """The picture, seen from above."""
    A_texture_road: Float[Array, "3 3"]
    """From (x, z, 1) of the `road` frame, metres, to the texture's pixels (u, v, 1); not
    singular."""
    reach: float = np.inf
    """Metres of depth up to which it is shown."""

    def __post_init__(self) -> None:
        A = self.A_texture_road
        if not np.isfinite(A).all() or abs(np.linalg.det(A)) < 1e-12:
            raise BadConfig(f"A_texture_road is singular or not finite: {A.tolist()}")


@dataclass(frozen=True, eq=False)
class Road:
    """The road plane, painted by a texture that looks down on it; by default plain asphalt, 2 km
    across."""

    texture: Texture = field(default_factory=_plain)
    """The picture, seen from above."""
    A_texture_road: Float[Array, "3 3"] = field(default_factory=_plain_map)
    """From (x, z, 1) of the `road` frame, metres, to the texture's pixels (u, v, 1); not
    singular."""
    around: Colour = GRASS_COLOUR
    """RGB of the plane outside the texture."""
    finer: tuple[Level, ...] = ()
    """Pictures of parts of the plane, from fine to coarse, drawn instead of the texture near the
    camera."""

    def __post_init__(self) -> None:
        Level(self.texture, self.A_texture_road)  # which checks them

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """All pictures of the plane, from fine to coarse."""
        return (*self.finer, Level(self.texture, self.A_texture_road))

    @property
    def is_plain(self) -> bool:
        """Whether it is the default one, which looks the same wherever the camera goes."""
        is_whole = self.texture is _plain() and not self.finer and self.around == GRASS_COLOUR
        return is_whole and np.array_equal(self.A_texture_road, _plain_map())

    @classmethod
    def spread(
        cls,
        texture: Texture,
        x: tuple[float, float],
        z: tuple[float, float],
        around: Colour = GRASS_COLOUR,
    ) -> "Road":
        """A texture between two x (left, right edge) and two z (lower, upper edge), metres."""
        if not (x[1] > x[0] and z[1] > z[0]):
            raise BadConfig(f"a road between x {x} and z {z}: give the smaller edge first")
        width, height = texture.size
        across, along = width / (x[1] - x[0]), height / (z[1] - z[0])
        A_texture_road = np.array(
            [
                [across, 0.0, -across * x[0] - 0.5],
                [0.0, -along, along * z[1] - 0.5],
                [0.0, 0.0, 1.0],
            ]
        )
        return cls(texture, A_texture_road, around)


@dataclass(frozen=True, eq=False)
class Cover:
    """A picture of the shadows that the sun casts on the road plane, seen from above."""

    pixels: UInt8[Array, "h w"]
    """How much of the sun is hidden, 255 = all of it; at least 2 x 2."""
    A_cover_road: Float[Array, "3 3"]
    """From (x, z, 1) of the `road` frame, metres, to the picture's pixels (u, v, 1); affine."""

    def __post_init__(self) -> None:
        if min(self.pixels.shape) < 2 or not np.isfinite(self.A_cover_road).all():
            raise BadConfig(
                f"a picture of shadows of {self.pixels.shape[1]} x {self.pixels.shape[0]} pixels, "
                f"A_cover_road {self.A_cover_road.tolist()}: give 2 x 2 or more, and finite numbers"
            )


@dataclass(frozen=True, eq=False)
class Panorama:
    """All that is too far away to shift: clouds, hills, the tops of distant trees."""

    rgba: UInt8[Array, "h w 4"]
    """Columns go once around to the right from azimuth 0 (world x); rows are elevations, evenly
    from `top` down to `bottom`. At least 2 x 2."""
    top: float
    """Elevation of the first row, radians; above `bottom`."""
    bottom: float
    """Elevation of the last row, radians."""

    def __post_init__(self) -> None:
        if min(self.rgba.shape[:2]) < 2 or not self.top > self.bottom:
            raise BadConfig(
                f"a panorama of {self.rgba.shape[1]} x {self.rgba.shape[0]} pixels from {self.top} "
                f"down to {self.bottom}: give 2 x 2 or more, and the top first"
            )

    @cached_property
    def twice(self) -> UInt8[Array, "h w2 4"]:
        """Twice around, so that every view of it is one piece."""
        return np.ascontiguousarray(np.concatenate((self.rgba, self.rgba), axis=1))


@dataclass(frozen=True)
class Sky:
    """A sky that fades from the horizon up, or a panorama."""

    top: Colour = (104, 150, 202)
    """RGB high up, where there is no panorama."""
    low: Colour = (222, 231, 236)
    """RGB at the horizon, where there is no panorama."""
    panorama: Panorama | None = None
    """What is drawn above the horizon; None: only the fading colours."""
    heading: float = 0.0
    """Direction in which the camera looks at the panorama, radians from world +x to the right."""


@dataclass(frozen=True)
class Sun:
    """Where light comes from, and how strong it is."""

    towards: tuple[float, float, float] = (-0.35, -0.75, -0.55)
    """Vector to the sun in the `road` frame (y is down), any length; y must be negative."""
    ambient: float = 0.45
    """Share of the light that a face turned away still gets, 0 to 1; more: less contrast."""
    shade: float = 0.55
    """Share of the road's light that a cast shadow takes, 0 to 1; more: darker shadows."""

    def __post_init__(self) -> None:
        if not self.towards[1] < 0.0:
            raise BadConfig(f"the sun at {self.towards} is below the road: y must be negative")
        for name, value in (("ambient", self.ambient), ("shade", self.shade)):
            if not 0.0 <= value <= 1.0:
                raise BadConfig(f"the sun's {name} is {value:g}: give 0 to 1")

    @property
    def direction(self) -> Float[Array, "3"]:
        """The unit vector to the sun."""
        towards = np.array(self.towards)
        return towards / np.linalg.norm(towards)

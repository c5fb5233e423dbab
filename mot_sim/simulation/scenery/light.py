"""Where the light of a world comes from."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.renderers import Sun
from tracker.errors import BadConfig


@dataclass(frozen=True)
class Light:
    """The sun of a world, and its clouds.

    azimuth: degrees from world +x towards +y. elevation: degrees above the horizon. ambient: of
    the light, what comes from the sky. shade: what a shadow takes of the ground's light; both 0
    to 1. clouds: the share of the sky they cover.
    """

    azimuth: float = 125.0
    elevation: float = 48.0
    ambient: float = 0.5
    shade: float = 0.5
    clouds: float = 0.35

    def __post_init__(self) -> None:
        if not (np.isfinite(self.azimuth) and 5.0 <= self.elevation <= 90.0):
            raise BadConfig(
                f"sun at azimuth {self.azimuth:g}, elevation {self.elevation:g} degrees: give an "
                "elevation of 5 to 90; dusk and night are darkness, not a lower sun"
            )
        for name in ("ambient", "shade", "clouds"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise BadConfig(f"{name} of the light is {value:g}: give 0 to 1")

    @property
    def towards_world(self) -> Float[Array, "3"]:
        """The unit vector to the sun; z is down."""
        azimuth, elevation = np.deg2rad(self.azimuth), np.deg2rad(self.elevation)
        level = np.cos(elevation)
        return np.array([level * np.cos(azimuth), level * np.sin(azimuth), -np.sin(elevation)])

    def sun(self, heading: float) -> Sun:
        """The sun in the road frame of a camera that looks along a heading, radians."""
        x, y, z = self.towards_world
        c, s = np.cos(heading), np.sin(heading)
        return Sun((float(c * y - s * x), float(z), float(c * x + s * y)), self.ambient, self.shade)

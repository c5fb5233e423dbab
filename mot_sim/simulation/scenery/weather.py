"""Light, weather, time of day and faults of the camera: what one post-effect makes of a frame."""

from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.simulation.renderers import Sun
from tracker.errors import BadConfig, UnknownName

Colour = tuple[int, int, int]
AIR_COLOUR: Colour = (206, 216, 224)
# The least and the most of every knob; the neutral value changes no byte.
RANGES: dict[str, tuple[float, float]] = {
    "visibility": (10.0, np.inf), "overcast": (0.0, 1.0), "rain": (0.0, 1.0),
    "night": (0.0, 1.0), "headlights": (0.0, 1.0), "warmth": (-1.0, 1.0),
    "glare": (0.0, 1.0), "exposure": (0.1, 10.0), "motion_blur": (0.0, 1.0),
    "noise": (0.0, 60.0), "vignetting": (0.0, 1.0), "jpeg": (1.0, 100.0),
}  # fmt: skip


@dataclass(frozen=True)
class Light:
    """The sun of a world, and its clouds."""

    azimuth: float = 125.0
    """Direction of the sun, degrees from world +x towards +y; any finite number."""
    elevation: float = 48.0
    """Height of the sun above the horizon, degrees, 5 to 90; lower: longer shadows."""
    ambient: float = 0.5
    """Share of the light that comes from the sky, 0 to 1; more: brighter sides away from the
    sun."""
    shade: float = 0.5
    """Share of the ground's light that a shadow takes, 0 to 1; more: darker shadows."""
    clouds: float = 0.35
    """Share of the sky that clouds cover, 0 to 1; changes only the drawn sky."""

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


@dataclass(frozen=True)
class Weather:
    """Knobs of the post-effect; all of them are neutral by default, and then no byte changes."""

    light: Light = Light()
    """Sun and clouds of the world that this weather belongs to, for `Neighbourhood.build`."""
    visibility: float = np.inf
    """Metres at which contrast has fallen to 2 %, >= 10 (Koschmieder's law: exp(-3.912 d / V) of
    it is left at d metres); lower: denser fog; inf: clear air."""
    air: Colour = AIR_COLOUR
    """Colour of fog and haze, RGB, 0 to 255 each."""
    overcast: float = 0.0
    """How far clouds cover the sky, 0 to 1; more: greyer sky, paler and darker colours."""
    rain: float = 0.0
    """How heavy the rain is, 0 to 1; more: more drops, a darker road that mirrors more."""
    night: float = 0.0
    """How dark it is, 0 to 1; more: less light from the sky, and lamps that glow."""
    headlights: float = 0.0
    """Strength of our headlights and of the glow around lamps, 0 to 1; seen only at night."""
    warmth: float = 0.0
    """Colour of the light, -1 (blue) to 1 (red)."""
    glare: float = 0.0
    """Strength of the halo around a sun ahead of the camera, 0 to 1; more: less contrast there."""
    exposure: float = 1.0
    """Gain on all colours, 0.1 to 10; higher: brighter, clipped at white."""
    motion_blur: float = 0.0
    """Share of the frame's time that the shutter is open, 0 to 1; more: longer blur."""
    noise: float = 0.0
    """Standard deviation of the sensor's noise, grey levels, 0 to 60; more: grainier images."""
    vignetting: float = 0.0
    """Share of the light that the image's corners lose, 0 to 1; more: darker corners."""
    jpeg: float = 100.0
    """Quality of the JPEG compression, 1 to 100; lower: more artefacts; 100: not compressed."""

    def __post_init__(self) -> None:
        for name, (least, most) in RANGES.items():
            value = getattr(self, name)
            if not least <= value <= most:
                raise BadConfig(f"{name} of the weather is {value:g}: give {least:g} to {most:g}")
        if not all(0 <= one <= 255 for one in self.air):
            raise BadConfig(f"air of the weather is {self.air}: give RGB, 0 to 255 each")

    @property
    def is_neutral(self) -> bool:
        """Whether it leaves every frame as it is."""
        clear = Weather()
        names = (field.name for field in fields(self) if field.name not in ("light", "air"))
        return all(getattr(self, name) == getattr(clear, name) for name in names)


OVERCAST_LIGHT = Light(ambient=0.9, shade=0.08, clouds=1.0)
NIGHT_LIGHT = Light(ambient=0.95, shade=0.0, clouds=0.5)
LOW_SUN_LIGHT = Light(azimuth=28.0, elevation=11.0, ambient=0.42, shade=0.55, clouds=0.25)

# The name of a weather, for scenes and the command line.
WEATHERS: dict[str, Weather] = {
    "clear": Weather(),
    "noon": Weather(visibility=1430.0, noise=1.6, vignetting=0.18),
    "low_sun": Weather(
        LOW_SUN_LIGHT, 1040.0, (238, 214, 176), warmth=0.55, glare=0.8, noise=2.0, vignetting=0.22
    ),
    "overcast": Weather(OVERCAST_LIGHT, 910.0, overcast=0.85, noise=2.2, vignetting=0.18),
    "fog": Weather(
        OVERCAST_LIGHT, 125.0, (196, 201, 204), overcast=1.0, noise=2.2, vignetting=0.15
    ),
    "rain": Weather(
        OVERCAST_LIGHT, 340.0, (166, 174, 182), overcast=1.0, rain=0.8, exposure=0.86, noise=2.8,
        vignetting=0.2,
    ),
    "dusk": Weather(
        NIGHT_LIGHT, 1170.0, (150, 140, 150), overcast=0.2, night=0.55, headlights=0.6, warmth=0.15,
        noise=4.0, vignetting=0.22,
    ),
    "night": Weather(
        NIGHT_LIGHT, 1960.0, (30, 34, 44), night=1.0, headlights=1.0, noise=5.5, vignetting=0.25
    ),
}  # fmt: skip


def find_weather(name: str) -> Weather:
    """The weather of a name; UnknownName for another."""
    if name not in WEATHERS:
        raise UnknownName.of("weather", name, WEATHERS)
    return WEATHERS[name]

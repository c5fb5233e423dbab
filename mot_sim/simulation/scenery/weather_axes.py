"""Weather with a range: fog, rain, sun and exposure in units; named weathers are points on them."""

from dataclasses import dataclass, replace

import numpy as np

from mot_sim.simulation.camera_looks import CameraLook
from mot_sim.simulation.scenery.weather import (
    OVERCAST_LIGHT,
    WEATHERS,
    Colour,
    Light,
    Weather,
)
from tracker.errors import BadConfig

KOSCHMIEDER = 3.912  # -ln(0.02): contrast left at the visibility
# The least, the most and the unit of each axis; 0 leaves to weather and camera what they have.
AXIS_RANGES: dict[str, tuple[float, float, str]] = {
    "fog": (10.0, 20_000.0, "metres of visibility"),
    "rain": (0.1, 150.0, "mm/h"),
    "sun_elevation": (5.0, 90.0, "degrees"),
    "exposure": (-3.0, 3.0, "stops"),
}
# The named weathers' places on the axes. Where fog lies between the two, the sun shines through.
FOG_METRES, SUNNY_METRES = WEATHERS["fog"].visibility, 2000.0
RAIN_MM, OVERCAST_MM = 16.0, 2.5  # of `rain`; from which on clouds cover all of the sky
RAIN_EXTINCTION = 0.67  # exponent of the rate: extinction by drops (Atlas 1953)
LOW_SUN, HIGH_SUN = WEATHERS["low_sun"], WEATHERS["noon"]
GLARE_ELEVATION = 25.0  # degrees: a higher sun makes no halo


@dataclass(frozen=True)
class WeatherAxes:
    """A weather shifted along continuous axes; 0 everywhere changes nothing."""

    fog: float = 0.0
    """Visibility in fog, metres, 10 to 20000; at d metres exp(-3.912 d / fog) of the contrast is
    left. 0: the weather's own."""
    rain: float = 0.0
    """Rain, mm/h, 0.1 to 150: 2.5 is moderate, 8 heavy, 50 violent. 0: the weather's own."""
    sun_elevation: float = 0.0
    """Height of the sun, degrees, 5 to 90; lower: longer shadows, warmer light. 0: the weather's
    own."""
    exposure: float = 0.0
    """Stops on the camera's exposure, -3 to 3; 1 doubles the light that it takes, -1 halves it."""

    def __post_init__(self) -> None:
        for name, (least, most, unit) in AXIS_RANGES.items():
            value = getattr(self, name)
            if value != 0.0 and not least <= value <= most:
                own = "none" if name == "exposure" else "the weather's own"
                raise BadConfig(
                    f"{name} = {value:g}: give {least:g} to {most:g} {unit}, or 0 for {own}"
                )

    def __call__(self, weather: Weather, look: CameraLook) -> tuple[Weather, CameraLook]:
        """The weather and the camera's look, shifted."""
        if self.sun_elevation:
            weather = under_sun(weather, self.sun_elevation)
        if self.fog:
            weather = in_fog(weather, self.fog)
        if self.rain:
            weather = in_rain(weather, self.rain)
        if self.exposure and look.is_neutral:
            weather = replace(weather, exposure=weather.exposure * 2.0**self.exposure)
        elif self.exposure:
            stops = look.exposure.stops + self.exposure
            look = replace(look, exposure=replace(look.exposure, stops=stops))
        return weather, look


def contrast_left(depth: float, visibility: float) -> float:
    """Share of the contrast that is left at a depth, metres (Koschmieder's law)."""
    return float(np.exp(-KOSCHMIEDER * depth / visibility))


def under_sun(weather: Weather, elevation: float) -> Weather:
    """The weather with its sun at an elevation, degrees; clouds hide what it changes.

    Light warms with the mass of air on its way, 1 / sin(elevation), up to `low_sun`'s at its 11.
    """
    light, low, high = weather.light, LOW_SUN.light, HIGH_SUN.light
    mass, least, most = (
        1.0 / np.sin(np.deg2rad(one)) for one in (elevation, high.elevation, low.elevation)
    )
    share = float(np.clip((mass - least) / (most - least), 0.0, 1.0)) * (1.0 - weather.overcast)
    light = replace(
        light,
        elevation=elevation,
        ambient=light.ambient + share * (low.ambient - high.ambient),
        shade=light.shade + share * (low.shade - high.shade),
    )
    halo = np.clip((GLARE_ELEVATION - elevation) / (GLARE_ELEVATION - low.elevation), 0.0, 1.0)
    return replace(
        weather,
        light=light,
        warmth=share * LOW_SUN.warmth,
        glare=float(halo) * (1.0 - weather.overcast) * LOW_SUN.glare,
        air=_between(weather.air, LOW_SUN.air, share),
    )


def in_fog(weather: Weather, visibility: float) -> Weather:
    """The weather with fog of a visibility, metres; the denser, the less sun comes through."""
    veiled = np.log(SUNNY_METRES / visibility) / np.log(SUNNY_METRES / FOG_METRES)
    return _clouded(weather, float(np.clip(veiled, 0.0, 1.0)), WEATHERS["fog"], visibility)


def in_rain(weather: Weather, rate: float) -> Weather:
    """The weather with rain of a rate, mm/h, under its clouds.

    Drops and spray take light with the rate^0.67, as much as `rain`'s at its rate; how much the
    spray takes is ours, not measured.
    """
    named, share = WEATHERS["rain"], min(rate / OVERCAST_MM, 1.0)
    seen = named.visibility * (RAIN_MM / rate) ** RAIN_EXTINCTION
    shifted = _clouded(weather, share, named, min(seen, weather.visibility))
    amount = 1.0 - (1.0 - named.rain) ** (rate / RAIN_MM)
    gain = named.exposure ** min(rate / RAIN_MM, 1.0)
    return replace(shifted, rain=amount, exposure=weather.exposure * gain)


def _clouded(weather: Weather, share: float, named: Weather, visibility: float) -> Weather:
    """The weather with this visibility, and a share of the way to a named weather's clouds.

    At night there is no sun to be hidden, and the air has the night's colour.
    """
    lit = share * (1.0 - weather.night)
    light = weather.light
    covered = Light(
        light.azimuth,
        light.elevation,
        (1.0 - lit) * light.ambient + lit * OVERCAST_LIGHT.ambient,
        (1.0 - lit) * light.shade + lit * OVERCAST_LIGHT.shade,
        (1.0 - share) * light.clouds + share * OVERCAST_LIGHT.clouds,
    )
    return replace(
        weather,
        light=covered,
        visibility=visibility,
        air=_between(weather.air, named.air, lit),
        overcast=max(weather.overcast, share * named.overcast),
        warmth=(1.0 - share) * weather.warmth,
        glare=(1.0 - share) * weather.glare,
    )


def _between(one: Colour, other: Colour, share: float) -> Colour:
    r, g, b = (
        round(float(first + share * (second - first)))
        for first, second in zip(one, other, strict=True)
    )
    return r, g, b

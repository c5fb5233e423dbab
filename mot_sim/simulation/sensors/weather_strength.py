"""Fog and rain as a detector sees them, in units: the named weathers made weaker and stronger."""

from mot_sim.simulation.sensors.profile import WEATHERS, Profile, SensorWeather

FOG_METRES = 125.0  # visibility of the named fog, as drawn
RAIN_MM = 16.0  # mm/h of the named rain, as drawn
RAIN_EXTINCTION = 0.67  # exponent of the rate (Atlas 1953)


def in_fog_and_rain(profile: Profile, fog: float, rain: float) -> Profile:
    """A profile in fog of a visibility, metres, and rain, mm/h; 0: none.

    The named weather's effect on log-odds grows with what the air takes of the light a metre:
    in fog with 1 / visibility (Koschmieder's law), in rain with rate^0.67.
    """
    if fog > 0.0:
        profile = weather_of_strength("fog", FOG_METRES / fog)(profile)
    if rain > 0.0:
        profile = weather_of_strength("rain", (rain / RAIN_MM) ** RAIN_EXTINCTION)(profile)
    return profile


def weather_of_strength(name: str, strength: float) -> SensorWeather:
    """A named weather so many times as strong; 1: itself, 0: none."""
    named = WEATHERS[name]
    return SensorWeather(
        strength * named.odds,
        strength * named.far,
        min(strength, 1.0) * named.glare,
        named.jitter**strength,
        named.clutter**strength,
        strength * named.score_shift,
    )

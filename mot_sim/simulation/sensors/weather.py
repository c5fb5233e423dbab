"""Weather as bundles: what rain, fog, glare and night do to a profile."""

from dataclasses import dataclass, replace

from mot_sim.simulation.sensors.profile import Profile
from tracker.errors import UnknownName


@dataclass(frozen=True)
class SensorWeather:
    """odds: added to the log-odds of being found; far: more of it for boxes below 35 px.

    glare: share of the misses that a frame's objects share, over half a second. jitter, clutter:
    factors. doubt: added to the latent of the scores. The numbers are ours, not measured.
    """

    odds: float = 0.0
    far: float = 0.0
    glare: float = 0.0
    jitter: float = 1.0
    clutter: float = 1.0
    doubt: float = 0.0

    def __call__(self, profile: Profile) -> Profile:
        """The profile in this weather; effects that it lacks stay away."""
        misses, jitter = profile.misses, profile.jitter
        scores, clutter = profile.scores, profile.clutter
        if misses is not None:
            small = tuple(
                odds + self.far * (number < 3) for number, odds in enumerate(misses.by_height)
            )
            misses = replace(
                misses,
                base=misses.base + self.odds,
                by_height=small,
                shared=max(misses.shared, self.glare),
                shared_seconds=0.5 if self.glare > misses.shared else misses.shared_seconds,
            )
        if jitter is not None:
            parts = {name: getattr(jitter, name) for name in ("x", "y", "width", "height")}
            jitter = replace(
                jitter, **{n: replace(p, spread=p.spread * self.jitter) for n, p in parts.items()}
            )
        if scores is not None:
            scores = replace(scores, by_visible=tuple(y + self.doubt for y in scores.by_visible))
        if clutter is not None:
            clutter = replace(clutter, rate=clutter.rate * self.clutter)
        return replace(profile, misses=misses, jitter=jitter, scores=scores, clutter=clutter)


WEATHERS: dict[str, SensorWeather] = {
    "clear": SensorWeather(),
    "rain": SensorWeather(-0.7, -0.3, 0.15, 1.3, 1.5, -0.3),
    "fog": SensorWeather(-0.5, -2.0, 0.1, 1.2, 0.8, -0.5),
    "glare": SensorWeather(-0.5, 0.0, 0.5, 1.2, 1.5, -0.4),
    "night": SensorWeather(-1.0, -0.7, 0.2, 1.4, 2.0, -0.6),
}


def in_weather(profile: Profile, name: str) -> Profile:
    """A profile in a weather of WEATHERS. Raises UnknownName."""
    if name not in WEATHERS:
        raise UnknownName.of("weather", name, WEATHERS)
    return WEATHERS[name](profile)

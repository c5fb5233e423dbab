"""A look of the camera: physical knobs of lens, exposure, tone, sensor and file, as one TOML."""

from dataclasses import dataclass, field, fields
from functools import lru_cache
from pathlib import Path
from typing import Any, get_type_hints

from mot_sim.files.documents import read_toml
from mot_sim.simulation.sensors.profile import dataclass_from_table
from tracker.errors import BadConfig, BadFile, UnknownName

LOOK_VERSION = 1  # of the files; a newer one may mean what this code does not know
LOOK_FOLDER = Path(__file__).parent
CAMERA_LOOKS = ("kitti", "plain")


def _require_within(part: object, ranges: dict[str, tuple[float, float]]) -> None:
    """Raise BadConfig for a knob outside its range, or that is no number."""
    name = type(part).__name__.lower()
    for knob, (least, most) in ranges.items():
        value = getattr(part, knob)
        if not least <= value <= most:
            raise BadConfig(
                f"{name}.{knob} of the camera's look is {value:g}: give {least:g} to {most:g}"
            )


@dataclass(frozen=True)
class Lens:
    """What the lens does to the light."""

    blur: float = 0.0
    """Standard deviation of the blur, pixels, 0 to 8; more: softer edges."""
    vignetting: float = 0.0
    """Share of the light that the image's corners lose, 0 to 0.95; more: darker corners."""

    def __post_init__(self) -> None:
        _require_within(self, {"blur": (0.0, 8.0), "vignetting": (0.0, 0.95)})


@dataclass(frozen=True)
class Exposure:
    """How much light the sensor gets, and how the colours are balanced, frame by frame."""

    gain: float = 1.0
    """Gain on the light, above 0 to 100; higher: brighter. The automatic exposure begins here."""
    mean: float = 0.0
    """Mean grey level that the automatic exposure aims at, 0 to 255; 0: `gain` in every frame."""
    max_stops: float = 2.0
    """By how many stops (factors of 2) the automatic exposure may change the gain, 0 to 10."""
    stops: float = 0.0
    """Stops on top of the automatic exposure, -8 to 8; higher: brighter, more is clipped."""
    white_balance: float = 0.0
    """Share of the frame's mean colour that is balanced to grey, 0 to 1; 0: colours as drawn."""
    red: float = 1.0
    """Gain on red after that, 0.25 to 4; more: warmer."""
    blue: float = 1.0
    """Gain on blue after that, 0.25 to 4; more: colder."""

    def __post_init__(self) -> None:
        if not 0.0 < self.gain <= 100.0:
            raise BadConfig(
                f"exposure.gain of the camera's look is {self.gain:g}: give more than 0, to 100; "
                "with 0 no light reaches the sensor"
            )
        _require_within(
            self,
            {
                "mean": (0.0, 255.0), "max_stops": (0.0, 10.0), "stops": (-8.0, 8.0),
                "white_balance": (0.0, 1.0), "red": (0.25, 4.0), "blue": (0.25, 4.0),
            },
        )  # fmt: skip


@dataclass(frozen=True)
class Tone:
    """From the drawn grey levels to light, and from the light that was measured to grey levels."""

    contrast: float = 1.0
    """Exponent from drawn grey levels to light, 0.2 to 5; more: deeper shadows, brighter lights."""
    saturation: float = 1.0
    """Factor on the colours' distance from grey before that, 0 to 4; less: paler."""
    shoulder: float = 0.0
    """How softly lights roll off below white: exponent, 1 to 20, softest at 1; 0: not at all."""
    black: float = 0.0
    """Grey level of what has no light, 0 to 100; more: paler shadows."""

    def __post_init__(self) -> None:
        _require_within(
            self, {"contrast": (0.2, 5.0), "saturation": (0.0, 4.0), "black": (0.0, 100.0)}
        )
        if self.shoulder != 0.0 and not 1.0 <= self.shoulder <= 20.0:
            raise BadConfig(
                f"tone.shoulder of the camera's look is {self.shoulder:g}: give 1 to 20, or 0 for "
                "none"
            )


@dataclass(frozen=True)
class Sensor:
    """Where light is clipped, and noise: variance = read_noise^2 + shot_noise^2 * grey level."""

    full_well: float = 1.0
    """Light at which a pixel is full, and clips to white, 0.1 to 20; less: more is clipped."""
    read_noise: float = 0.0
    """Standard deviation of the noise in the dark, grey levels, 0 to 60."""
    shot_noise: float = 0.0
    """Noise that grows with the square root of the light: standard deviation at a grey level of
    1, 0 to 10. Both kinds of noise grow with the root of what the exposure adds to the gain."""
    shared: float = 0.85
    """Share of the noise that the three colours have in common, 0 to 1; 1: grey noise."""
    grain: float = 0.0
    """Standard deviation of the noise's grains, pixels, 0 to 4; 0: pixels differ freely."""

    def __post_init__(self) -> None:
        _require_within(
            self,
            {
                "full_well": (0.1, 20.0), "read_noise": (0.0, 60.0), "shot_noise": (0.0, 10.0),
                "shared": (0.0, 1.0), "grain": (0.0, 4.0),
            },
        )  # fmt: skip


@dataclass(frozen=True)
class File:
    """How the image is written by the camera."""

    jpeg: float = 100.0
    """Quality of the JPEG compression, 1 to 100; lower: more artefacts; 100: not compressed."""

    def __post_init__(self) -> None:
        _require_within(self, {"jpeg": (1.0, 100.0)})


@dataclass(frozen=True)
class CameraLook:
    """What a camera makes of the light that reaches it; neutral by default: no byte changes.

    It replaces the noise, vignetting and JPEG of the weather, unless it is neutral. Depth, labels
    and ids stay as they are.
    """

    name: str = "plain"
    """What it is called."""
    source: str = ""
    """Where its numbers come from."""
    lens: Lens = field(default_factory=Lens)
    """Blur and vignetting."""
    exposure: Exposure = field(default_factory=Exposure)
    """Automatic exposure and white balance."""
    tone: Tone = field(default_factory=Tone)
    """Contrast and colours."""
    sensor: Sensor = field(default_factory=Sensor)
    """Clipping and noise."""
    file: File = field(default_factory=File)
    """Compression."""

    @property
    def is_neutral(self) -> bool:
        """Whether it leaves every frame to the weather alone."""
        return all(getattr(self, name) == kind() for name, kind in LOOK_TABLES.items())


# The tables of a look's file by name, in their order.
LOOK_TABLES: dict[str, type] = {
    name: kind for name, kind in get_type_hints(CameraLook).items() if kind is not str
}
PLAIN = CameraLook()


def find_camera_look(name: str) -> CameraLook:
    """The look of a name of CAMERA_LOOKS, or of a TOML file.

    Raises UnknownName, BadFile and BadConfig.
    """
    if name in CAMERA_LOOKS:
        return _ours(name)
    if name.endswith(".toml"):
        return read_camera_look(Path(name))
    raise UnknownName.of("camera_look", name, (*CAMERA_LOOKS, "FILE.toml"))


@lru_cache(maxsize=len(CAMERA_LOOKS))
def _ours(name: str) -> CameraLook:
    return read_camera_look(LOOK_FOLDER / f"{name}.toml")


def read_camera_look(path: Path) -> CameraLook:
    """A look's file, checked; knobs that it leaves out are neutral.

    Raises BadFile when it is no TOML or of a newer version, UnknownName for a knob that there is
    not, BadConfig for a value that cannot be.
    """
    content = read_toml(path, "no look of a camera can be read")
    version = content.pop("version", None)
    if not isinstance(version, int) or not 1 <= version <= LOOK_VERSION:
        raise BadFile(
            f"{path}: a camera's look of version {version}; this mot-sim reads up to "
            f"{LOOK_VERSION}: write version = {LOOK_VERSION} above the tables"
        )
    given: dict[str, Any] = {"name": path.stem} | {
        key: content.pop(key) for key in ("name", "source") if key in content
    }
    for key, word in given.items():
        if not isinstance(word, str):
            raise BadConfig(f"{path}: {key} = {word!r}: give a word")
    for key, table in content.items():
        if key not in LOOK_TABLES:
            raise UnknownName.of(f"part of a camera's look in {path.name}:", key, LOOK_TABLES)
        try:
            given[key] = dataclass_from_table(LOOK_TABLES[key], table, f"[{key}]")
        except BadConfig as error:
            raise BadConfig(f"{path}: {error}") from None
        except UnknownName as error:
            raise UnknownName(f"{path}: {error}") from None
    return CameraLook(**given)


def look_lines(look: CameraLook) -> list[str]:
    """The TOML of a look; `read_camera_look` gives the same back."""
    lines = [f"version = {LOOK_VERSION}", f'name = "{look.name}"', f'source = "{look.source}"']
    for name in LOOK_TABLES:
        part = getattr(look, name)
        lines += ["", f"[{name}]"]
        lines += [f"{each.name} = {float(getattr(part, each.name))!r}" for each in fields(part)]
    return lines

"""`mot-sim doctor`: what is installed here, and what works."""

import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path

from mot_sim.cli.options import Flag, Root, Verbose
from mot_sim.cli.terminal import BROKEN, OK, Terminal

CORE_PACKAGES = ("numpy", "scipy", "cv2", "numba", "filterpy", "jaxtyping", "tyro", "rich")
OPENGL_LIBRARIES = ("EGL", "OSMesa", "GL")
OLDEST_PYTHON = (3, 11)


@dataclass(frozen=True)
class Check:
    """One line of the diagnosis."""

    what: str
    """What was looked at."""
    state: str
    """ok; missing: something optional is; broken: something that everything needs does not work."""
    detail: str
    """What was found, or what to do."""


@dataclass(frozen=True)
class Doctor:
    """Say what is installed here and what works.

    mot-sim doctor --root KITTI

    Versions, the build of OpenCV, the data, OpenGL without a screen, video codecs, where compiled
    code is kept. Ends with exit code 1 when something is broken that everything needs, else with 0.
    """

    root: Root = None
    """A KITTI tree to look into."""
    warm: Flag = False
    """Compile now what would be compiled when it is first needed, and nothing else."""
    json: Flag = False
    """Print the findings as JSON."""
    verbose: Verbose = 0
    """Say more: -v, -vv."""

    def __call__(self, terminal: Terminal) -> int:
        """Check everything; never fails."""
        from mot_sim.tables import Column, Table

        findings = list(compile_kernels(terminal) if self.warm else self._found())
        if self.json:
            terminal.write_json({"findings": [asdict(finding) for finding in findings]})
        else:
            rows = tuple((each.what, each.state, each.detail) for each in findings)
            terminal.show(Table((Column("what"), Column("state"), Column("detail")), rows))
        return BROKEN if any(finding.state == "broken" for finding in findings) else OK

    def _found(self) -> Iterator[Check]:
        """Everything that is looked at without `warm`."""
        yield find_python()
        yield from (find_package(name) for name in CORE_PACKAGES)
        yield find_opencv()
        yield from find_kitti(self.root)
        yield from (find_library(name) for name in OPENGL_LIBRARIES)
        yield find_film()
        yield find_kernel_cache()


def find_python() -> Check:
    """The interpreter."""
    import platform

    state = "ok" if sys.version_info >= OLDEST_PYTHON else "broken"
    return Check("Python", state, f"{platform.python_version()} on {platform.platform()}")


def find_package(name: str) -> Check:
    """A package that everything needs."""
    try:
        module = import_module(name)
    except Exception as error:  # noqa: BLE001 - whatever a broken package raises is the finding
        return Check(name, "broken", f"cannot be imported: {error}")
    return Check(name, "ok", str(getattr(module, "__version__", "")) or _installed(name))


def find_kernel_cache() -> Check:
    """Where compiled code is kept."""
    from tracker.kernels import cache_folder

    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return Check("compiled code", "ok", f"kept in {folder}")
    except OSError as error:
        cure = "every process compiles anew; name another folder in NUMBA_CACHE_DIR"
        return Check("compiled code", "missing", f"cannot be kept in {folder} ({error}): {cure}")


def compile_kernels(terminal: Terminal) -> Iterator[Check]:
    """Compile all kernels that are not compiled yet."""
    from mot_sim.simulation.kernels import PACKAGE
    from tracker.errors import TrackingError
    from tracker.kernels import modules_of, warm

    modules = [*modules_of(), *modules_of(PACKAGE)]
    with terminal.progress(len(modules)) as advance:
        try:
            for module, seconds, is_new in warm(modules):
                advance(module)
                how = f"compiled in {seconds:.1f} s" if is_new else "compiled before"
                yield Check(module, "ok", how)
        except TrackingError as error:
            yield Check("compiled code", "broken", str(error))


def find_opencv() -> Check:
    """Which builds of OpenCV are installed: two write over each other's files."""
    from importlib.metadata import distributions

    builds = {
        str(found.metadata["Name"]).lower(): found.version
        for found in distributions()
        if str(found.metadata["Name"]).lower().startswith("opencv")
    }
    shown = ", ".join(f"{name} {number}" for name, number in sorted(builds.items()))
    try:
        warps = hasattr(import_module("cv2"), "warpPerspective")
    except ImportError:
        warps = False
    if not warps:
        cure = "pip install --force-reinstall 'opencv-python-headless>=4.11'"
        return Check("OpenCV build", "broken", f"{shown or 'none'}: no warpPerspective; {cure}")
    if set(builds) == {"opencv-python-headless"}:
        return Check("OpenCV build", "ok", f"{shown}, no other beside it")
    advice = "uninstall all but opencv-python-headless, then reinstall that"
    return Check("OpenCV build", "missing", f"not the headless build alone: {shown}; {advice}")


def find_kitti(root: Path | None) -> list[Check]:
    """What a KITTI tree holds."""
    from mot_sim.datasets import available_sequences, find_root
    from tracker.errors import TrackingError

    try:
        folder = find_root(root)
        splits = [split for split in ("training", "testing") if (folder / split).is_dir()]
        findings = [Check("KITTI root", "ok", str(folder))]
        for split in splits:
            names = available_sequences(folder, split)
            findings.append(Check(f"{split} sequences", _state(names), _shown(names)))
            for kind in ("label_02", "oxts", "image_02"):
                there = sorted({path.stem for path in (folder / split / kind).glob("[0-9]*")})
                findings.append(Check(f"{split}/{kind}", _state(there), _shown(there)))
    except (TrackingError, OSError) as error:
        return [Check("KITTI root", "missing", str(error))]
    for kind in ("detections", "odometry"):
        there = sorted(path.name for path in (folder / kind).glob("*/"))
        findings.append(Check(kind, _state(there), ", ".join(there) or "none"))
    return findings


def find_library(name: str) -> Check:
    """A library for OpenGL without a screen."""
    import ctypes
    import ctypes.util

    try:
        found = ctypes.util.find_library(name)
        if found is None:
            return Check(f"OpenGL: {name}", "missing", "no such library")
        ctypes.CDLL(found)
    except OSError as error:
        return Check(f"OpenGL: {name}", "missing", f"cannot be loaded: {error}")
    return Check(f"OpenGL: {name}", "ok", found)


def find_film() -> Check:
    """Whether ffmpeg writes H.264 here."""
    from mot_sim.plotting.video import find_ffmpeg
    from tracker.errors import BadConfig

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "try.mp4"
        try:
            found = find_ffmpeg()
        except BadConfig as error:
            return Check("video: H.264", "missing", str(error))
        works = _try(lambda: _write_video(path))
    detail = f"writes .mp4 and .gif: {found}" if works else f"{found} writes no .mp4 here"
    return Check("video: H.264", "ok" if works else "missing", detail)


def _write_video(path: Path) -> bool:
    import numpy as np

    from mot_sim.plotting import write_video

    return write_video(path, [np.zeros((48, 64, 3), np.uint8)] * 3, 10.0).is_file()


def _try(attempt: Callable[[], bool]) -> bool:
    try:
        return attempt()
    except Exception:  # noqa: BLE001 - a doctor reports what fails, whatever it raises
        return False


def _installed(name: str) -> str:
    from importlib.metadata import distributions

    return next((each.version for each in distributions() if each.metadata["Name"] == name), "")


def _state(names: list[str]) -> str:
    return "ok" if names else "missing"


def _shown(names: list[str]) -> str:
    """How many, and which; neighbours in number as a range."""
    if not names:
        return "none"
    parts: list[list[str]] = []
    for name in names:
        if parts and name.isdecimal() and int(name) == int(parts[-1][-1]) + 1:
            parts[-1].append(name)
        else:
            parts.append([name])
    ranges = [part[0] if len(part) == 1 else f"{part[0]}-{part[-1]}" for part in parts]
    return f"{len(names)}: {', '.join(ranges)}"

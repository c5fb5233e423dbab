"""The contact sheet of the worst switches: a picture of each, and one that shows them all."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float
from numpy import ndarray as Array

from mot_sim.datasets.images import ImageSource
from mot_sim.diagnosis.diagnosed_sequence import DiagnosedSequence, vehicles
from mot_sim.diagnosis.findings import Case, Findings
from mot_sim.diagnosis.tasks import KittiTask, SceneTask, Task
from mot_sim.metrics.breaks import box_of
from mot_sim.plotting import write_image
from mot_sim.plotting.canvas import Image, draw_box, draw_dashed_box, draw_text, text_width
from mot_sim.plotting.colours import (
    DETECTION_COLOUR,
    FAINT_COLOUR,
    NEUTRAL_COLOUR,
    PANEL_COLOUR,
    SWITCH_COLOUR,
    TEXT_COLOUR,
    TRUE_COLOUR,
    Colour,
    colour_of_id,
    ink_on,
)
from mot_sim.plotting.drawing import Area, plain_ground, tag
from mot_sim.simulation.imaging import RenderedImages
from mot_sim.simulation.scene import Rollout
from tracker.errors import BadOutput
from tracker.types import Tracks

CROP_SIZE_PIXELS = (308, 220)
GAP_PIXELS = 4
TITLE_BAR_PIXELS = 34
CAPTION_PIXELS = 22
SHEET_WIDTH_PIXELS = 4 * CROP_SIZE_PIXELS[0] + 3 * GAP_PIXELS
CROP_CAR_HEIGHTS = 3.2  # height of a crop over that of the car
MIN_CROP_PIXELS = 60.0  # height of a crop: small cars are shown with more around them
THUMBNAIL_SCALE = 0.55
LEGEND = (
    "white dashes: the car   grey dashes: other cars",
    "light grey: detections   colours: ids given",
)
SHEET_FILE = "sheet.png"
MAX_STRIPS = 12  # on the sheet
STRIP_GAP_PIXELS = 10
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True, eq=False)
class Scenario:
    """A drive with the tracker's output, as the contact sheet shows it."""

    diagnosed: DiagnosedSequence
    """The drive, its labels and its events."""
    output: Tracks
    """All rows of the tracker."""
    images: ImageSource | None = None
    """The images of the drive; None: boxes are drawn on a plain ground."""

    @cached_property
    def cars(self) -> Tracks:
        """The true boxes."""
        return vehicles(self.diagnosed.truth)

    def image(self, frame: int) -> Image:
        """The image of a frame, or a plain one; a copy."""
        found = None if self.images is None else self.images.load(frame)
        if found is None:
            return plain_ground(self.diagnosed.stream.camera, "no image: boxes only")
        return found.copy()


def draw_case(scenario: Scenario, case: Case, number: int) -> tuple[Array, Array]:
    """A switch as a whole picture, and as a strip of the four crops. number: its rank."""
    frames = frames_of(scenario, case)
    images = {frame: scenario.image(frame) for frame in dict.fromkeys(frames)}
    window = _window(scenario, case)
    crops = [_captioned(scenario, case, frame, images[frame], window) for frame in frames]
    strip = np.concatenate((_title(case, number), _side_by_side(crops)))
    whole = _whole(scenario, case, images[case.frame], window)
    return np.concatenate((strip, _with_facts(whole, case))), strip


def frames_of(scenario: Scenario, case: Case) -> tuple[int, int, int, int]:
    """The last frame under the old id (or two before), one before, the switch, one after."""
    came = scenario.diagnosed.stream.frames
    at = int(np.searchsorted(came, case.frame))
    before, after = int(came[max(at - 1, 0)]), int(came[min(at + 1, len(came) - 1)])
    first = case.before if case.before < before else int(came[max(at - 2, 0)])
    return first, before, case.frame, after


def _window(scenario: Scenario, case: Case) -> Float[Array, "4"]:
    """The part of the image that is shown, around the car on both sides of the switch."""
    boxes = [box_of(scenario.cars, case.car, frame) for frame in (case.before, case.frame)]
    known = np.array([each for each in boxes if each is not None])
    low, high = known[:, :2].min(axis=0), known[:, 2:].max(axis=0)
    height = float((known[:, 3] - known[:, 1]).max())
    aspect = CROP_SIZE_PIXELS[0] / CROP_SIZE_PIXELS[1]
    tall = max(
        CROP_CAR_HEIGHTS * height,
        MIN_CROP_PIXELS,
        1.3 * (high[1] - low[1]),
        1.3 * (high[0] - low[0]) / aspect,
    )
    half = 0.5 * tall * np.array([aspect, 1.0])
    size = np.array(scenario.diagnosed.stream.camera.image_size, float)
    middle = np.clip(
        0.5 * (low + high), np.minimum(half, 0.5 * size), size - np.minimum(half, 0.5 * size)
    )
    return np.concatenate((middle - half, middle + half))


def _captioned(
    scenario: Scenario, case: Case, frame: int, image: Image, window: Float[Array, "4"]
) -> Array:
    """A crop with its frame, and the id that the car has in it."""
    crop = _crop(image, window)
    _draw_boxes(crop, scenario, case, frame, window)
    bar = np.full((CAPTION_PIXELS, CROP_SIZE_PIXELS[0], 3), PANEL_COLOUR, np.uint8)
    steps = frame - case.frame
    when = "t" if steps == 0 else f"t {'-' if steps < 0 else '+'} {abs(steps)}"
    track_id = _track_id_in(case, frame)
    draw_text(
        bar, f"{when}   frame {frame}", (6, 16), SWITCH_COLOUR if steps == 0 else TEXT_COLOUR, 14
    )
    if track_id is not None:
        _chip(bar, f"id {track_id}", colour_of_id(track_id))
    if steps == 0:
        cv2.rectangle(crop, (0, 0), (crop.shape[1] - 1, crop.shape[0] - 1), SWITCH_COLOUR, 2)
    return np.concatenate((bar, crop))


def _chip(bar: Image, words: str, colour: Colour) -> None:
    """Words on a colour, at the right end of a bar."""
    width = text_width(words, 14) + 10
    left = bar.shape[1] - width
    cv2.rectangle(bar, (left, 2), (bar.shape[1] - 1, CAPTION_PIXELS - 3), colour, cv2.FILLED)
    draw_text(bar, words, (left + 5, 16), ink_on(colour), 14)


def _track_id_in(case: Case, frame: int) -> int | None:
    """The id that CLEAR gives the car in the two frames that make the switch."""
    return {case.before: case.old_track_id, case.frame: case.track_id}.get(frame)


def _crop(image: Image, window: Float[Array, "4"]) -> Array:
    """A part of the image at the size of a panel; dark outside the image."""
    scale = CROP_SIZE_PIXELS[0] / (window[2] - window[0])
    A = np.array([[scale, 0.0, -scale * window[0]], [0.0, scale, -scale * window[1]]])
    method = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
    return cv2.warpAffine(image, A, CROP_SIZE_PIXELS, flags=method, borderValue=PANEL_COLOUR)


def _draw_boxes(
    crop: Image, scenario: Scenario, case: Case, frame: int, window: Float[Array, "4"]
) -> None:
    """Detections, true boxes and tracks; those of this switch on top."""
    stream = scenario.diagnosed.stream
    for corners in _inside(stream.log.at(frame).boxes, window)[0]:
        draw_box(crop, corners, DETECTION_COLOUR, 4)
    cars = scenario.cars.select(scenario.cars.frames == frame)
    boxes, rows = _inside(cars.boxes, window)
    for corners, row in zip(boxes, rows.tolist(), strict=True):
        if cars.ids[row] != case.car:
            draw_dashed_box(crop, corners, NEUTRAL_COLOUR, 1, 4.0)
    tracks = scenario.output.select(scenario.output.frames == frame)
    placed, shown = _inside(tracks.boxes, window)
    switched = np.isin(tracks.ids[shown], (case.old_track_id, case.track_id))
    order, taken = np.argsort(switched, kind="stable").tolist(), list[Area]()
    for at in order:
        colour = colour_of_id(int(tracks.ids[shown[at]]))
        draw_box(crop, placed[at], colour, 3 if switched[at] else 1)
    for at in reversed(order):  # the tags of other cars give way
        track_id = int(tracks.ids[shown[at]])
        tag(crop, str(track_id), placed[at], colour_of_id(track_id), taken=taken)
    for corners, row in zip(boxes, rows.tolist(), strict=True):
        if cars.ids[row] == case.car:
            draw_dashed_box(crop, corners, TRUE_COLOUR, 2, 5.0)


def _inside(boxes: Float[Array, "n 4"], window: Float[Array, "4"]) -> tuple[Array, Array]:
    """The boxes that reach into the window, in pixels of the panel, and which they are."""
    rows = np.flatnonzero(
        (boxes[:, :2] < window[2:]).all(axis=1) & (boxes[:, 2:] > window[:2]).all(axis=1)
    )
    scale = CROP_SIZE_PIXELS[0] / (window[2] - window[0])
    return scale * (boxes[rows] - np.tile(window[:2], 2)), rows


def _title(case: Case, number: int) -> Image:
    """Which switch it is, and its cause."""
    bar = np.full((TITLE_BAR_PIXELS, SHEET_WIDTH_PIXELS, 3), PANEL_COLOUR, np.uint8)
    words = (
        f"{number}.  {case.drive}   car {case.car}: id {case.old_track_id} in frame {case.before}, "
    )
    end = draw_text(
        bar, f"{words}id {case.track_id} in frame {case.frame}", (8, 23), TEXT_COLOUR, 17
    )
    cause = cause_words(case)
    if cause:
        left = max(SHEET_WIDTH_PIXELS - text_width(cause, 16) - 8, end + 20)
        draw_text(bar, cause, (left, 23), SWITCH_COLOUR, 16)
    return bar


def cause_words(case: Case) -> str:
    """The cause of a switch in a few words; empty if it was not attributed."""
    if case.sources:
        return f"hangs on {' or '.join(case.sources)}"
    return f"unexplained: {case.verdict}" if case.verdict else ""


def _side_by_side(pictures: list[Array]) -> Array:
    gap = np.full((pictures[0].shape[0], GAP_PIXELS, 3), PANEL_COLOUR, np.uint8)
    parts = [part for picture in pictures for part in (picture, gap)]
    return np.concatenate(parts[:-1], axis=1)


def _whole(scenario: Scenario, case: Case, image: Image, window: Float[Array, "4"]) -> Array:
    """The frame of the switch, small, with the part that the crops show."""
    small = cv2.resize(
        image, None, fx=THUMBNAIL_SCALE, fy=THUMBNAIL_SCALE, interpolation=cv2.INTER_AREA
    )
    tracks = scenario.output.select(scenario.output.frames == case.frame)
    for row in range(len(tracks)):
        draw_box(small, THUMBNAIL_SCALE * tracks.boxes[row], colour_of_id(int(tracks.ids[row])), 1)
    draw_box(small, THUMBNAIL_SCALE * window, SWITCH_COLOUR, 2)
    return small


def _with_facts(whole: Image, case: Case) -> Array:
    """The small image, and beside it the events around the switch and the legend."""
    found = np.full(
        (whole.shape[0] + 2 * GAP_PIXELS, SHEET_WIDTH_PIXELS, 3), PANEL_COLOUR, np.uint8
    )
    found[GAP_PIXELS:-GAP_PIXELS, : whole.shape[1]] = whole[:, :SHEET_WIDTH_PIXELS]
    left = whole.shape[1] + 14
    around = [
        name for name in case.around if "," in name or f"{name}, " not in "; ".join(case.around)
    ]
    lines = ["around it:", *(f"   {name}" for name in around or ["none of the known events"])]
    lines += [f"the shorter of its two runs: {case.weight} frames"]
    for number, words in enumerate(lines):
        draw_text(found, words, (left, 26 + 20 * number), TEXT_COLOUR, 15)
    bottom = found.shape[0] - 12
    draw_text(found, LEGEND[0], (left, bottom - 18), FAINT_COLOUR, 14)
    draw_text(found, LEGEND[1], (left, bottom), FAINT_COLOUR, 14)
    return found


def worst_first(found: Sequence[Findings], max_switches: int) -> list[Case]:
    """The switches that tear off most of an identity, by the length of the shorter run."""
    switches = [case for each in found for case in each.cases if case.switched]
    return sorted(switches, key=lambda each: -each.weight)[:max_switches]


def draw_contact_sheet(
    folder: Path,
    found: Sequence[Findings],
    tasks: Sequence[Task],
    *,
    max_switches: int,
    renderer: str | None = "raster",
    progress: Progress | None = None,
) -> list[Path]:
    """Draw the worst switches; returns the files, the sheet first, or none without a switch.

    renderer: of the images of scenes; None: boxes on plain ground. KITTI's own images are used
    if the tree has them. Raises BadOutput, and NoOpenGL for a renderer that cannot work here.
    """
    cases = worst_first(found, max_switches)
    if not cases:
        return []
    require_folder(folder)
    by_name = {task.name: task for task in tasks}
    strips: dict[int, Array] = {}
    files: dict[int, Path] = {}
    done = 0
    for name in dict.fromkeys(case.drive for case in cases):
        scenario = scenario_of(by_name[name], renderer)
        for number, case in enumerate(cases, 1):
            if case.drive != name:
                continue
            whole, strip = draw_case(scenario, case, number)
            if number <= MAX_STRIPS:
                strips[number] = strip
            drive = name.replace("/", "_")
            files[number] = folder / f"{number:02d}_{drive}_car{case.car}_frame{case.frame}.png"
            write_image(files[number], whole)
            done += 1
            if progress is not None:
                progress("pictures", done, len(cases))
    write_image(folder / SHEET_FILE, _stacked([strips[number] for number in sorted(strips)]))
    return [folder / SHEET_FILE, *(files[number] for number in sorted(files))]


def require_folder(folder: Path) -> None:
    """Make the folder. Raises BadOutput where that fails."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadOutput(f"{folder}: no folder for pictures: {error.strerror}") from None


def scenario_of(task: Task, renderer: str | None) -> Scenario:
    """A drive, the tracker's output, and the images."""
    diagnosed, output = task.track()
    images: ImageSource | None = None
    if isinstance(task, KittiTask):
        images = task.pictures
    elif isinstance(task, SceneTask) and renderer is not None:
        take = Rollout.of(task.conditions.make_scene(), task.seed, task.recorded.traffic)
        images = RenderedImages(take, renderer)
    return Scenario(diagnosed, output, images)


def _stacked(strips: list[Array]) -> Array:
    """The strips one below the other."""
    space = np.full((STRIP_GAP_PIXELS, SHEET_WIDTH_PIXELS, 3), PANEL_COLOUR, np.uint8)
    parts = [part for strip in strips for part in (strip, space)]
    return np.concatenate(parts[:-1])

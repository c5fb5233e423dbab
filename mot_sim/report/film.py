"""The frames of a drive as a film: title, camera view with marks, top view, legend."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import cv2
import numpy as np

from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.metrics.breaks import Verdicts
from mot_sim.plotting.canvas import Image, draw_text, text_width
from mot_sim.plotting.colours import (
    FAINT_COLOUR,
    PANEL_COLOUR,
    TEXT_COLOUR,
    TRUE_COLOUR,
    colour_of_id,
)
from mot_sim.plotting.drawing import (
    SWITCH_FRAMES,
    Area,
    draw_areas,
    draw_detections,
    draw_false,
    draw_switch,
    draw_tracks,
    draw_true_boxes,
    plain_ground,
)
from mot_sim.report.error_strip import ErrorStrip
from mot_sim.report.expectations import ExpectedTracks, expectations
from mot_sim.report.ground import GroundMap
from mot_sim.report.topview import TopView
from mot_sim.report.wireframes import Fitting, Wireframes, draw_cuboids, draw_wireframes
from mot_sim.simulation.episode import SimulatedDrive
from tracker.geometry import box_iou
from tracker.types import TRACKED_KINDS, Detections, Frame, Tracks

TITLE_PIXELS = 32
LINE_PIXELS = 19
LEGEND_TEXT_PIXELS = 14
MARGIN_PIXELS = 12
TOP_VIEW_PIXELS = 313  # pixels: with KITTI's 375 and the title it makes 720
PIXELS_PER_METRE = 7.8  # in the top view
METRES_BEHIND = 14.0  # behind us, in the top view
TRAIL_FRAMES = 25
MIN_DETECTED_IOU = 0.5


@dataclass(frozen=True)
class Layers:
    """What is drawn in a film."""

    detections: bool = True
    """Whether detections are drawn, thin and grey."""
    truth: bool = False
    """Whether true boxes and outlines, missed cars, false boxes and switches are drawn, where
    labels are given."""
    search_areas: bool = False
    """Whether the area in which each track is expected is tinted."""
    wireframes: bool = False
    """Whether shapes fitted to the image are drawn as wires."""
    true_wireframes: bool = False
    """Whether the true shapes of a simulated drive are drawn as wires."""
    cuboids: bool = False
    """Whether tracks are drawn in the image as their cuboids, not as boxes."""
    top_view: bool = True
    """Whether the view from above is shown below the image."""
    follow: bool = True
    """Whether the view from above moves and turns with our car; else it stays where the film
    begins."""


def title_words(name: str, index: int, seconds: float, switches: int | None) -> str:
    """Which frame it is, and how many switches there were so far, if that is known."""
    words = f"{name}   frame {index:03d}   {seconds:4.1f} s"
    if switches is not None:
        words += f"   {switches} switch{'es' * (switches != 1)} so far"
    return words


def title(width: int, left: str, tracker: str, detections: bool) -> Image:
    """The bar above a frame; who tracked stands on the right where there is room."""
    bar = plain_bar(width, TITLE_PIXELS)
    draw_text(bar, left, (MARGIN_PIXELS, 22), TEXT_COLOUR, 18)
    right = f"colour and number: tracks of '{tracker}'"
    if detections:
        right = f"thin grey: detections (without: predicted)   {right}"
    start = width - text_width(right, 15) - MARGIN_PIXELS
    if start > MARGIN_PIXELS + text_width(left, 18):
        draw_text(bar, right, (start, 22), FAINT_COLOUR, 15)
    return bar


def marks(layers: Layers, outlines: bool) -> list[str]:
    """What each kind of mark means. outlines: whether true outlines are drawn from above."""
    parts = []
    if layers.search_areas:
        parts.append("tinted: where a track is expected (1 sigma)")
    if layers.truth:
        parts += [
            "dashed white: true box",
            "grey: one that need not be found (van, hidden, cut)",
            "red: missed",
            "red cross: false box",
            "yellow: new id",
        ]
    if layers.cuboids:
        parts.append("tinted: front of a track's cuboid")
    if layers.wireframes:
        parts.append("wires: fitted shape")
    if layers.true_wireframes:
        parts.append("white wires: true shape")
    if layers.top_view:
        true = "white: truth, " if outlines else ""
        parts.append(
            f"from above: {true}coloured: tracks, solid tip: their nose, hollow tip: perhaps it, "
            "tinted: 2 sigma of their place, thin: their paths"
        )
    return parts


def legend(width: int, parts: Sequence[str]) -> Image:
    """A bar with as many lines as the parts need."""
    lines = wrap(parts, width - 2 * MARGIN_PIXELS)
    bar = plain_bar(width, LINE_PIXELS * len(lines) + 6)
    for number, words in enumerate(lines):
        draw_text(
            bar,
            words,
            (MARGIN_PIXELS, LINE_PIXELS * (number + 1) - 2),
            TEXT_COLOUR,
            LEGEND_TEXT_PIXELS,
        )
    return bar


def wrap(parts: Sequence[str], width: int) -> list[str]:
    """The parts on lines of at most `width` pixels, if each part fits on a line."""
    lines: list[str] = []
    for part in parts:
        longer = f"{lines[-1]}    {part}" if lines else part
        if lines and text_width(longer, LEGEND_TEXT_PIXELS) <= width:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines


def plain_bar(width: int, height: int) -> Image:
    """A bar with nothing on it."""
    bar = np.empty((height, width, 3), np.uint8)
    bar[:] = PANEL_COLOUR
    return bar


@dataclass(frozen=True, eq=False)
class Film:
    """Frames of 1242 x 720 pixels for KITTI's camera, drawn one by one when asked for.

    Where labels and tracks have cuboids, a strip of their errors makes it 812.
    """

    drive: RecordedSequence
    """The drive, with its detections and its images, if it has any."""
    tracks: Tracks
    """The tracks that are shown."""
    tracker_name: str = "default"
    """The name in the title."""
    layers: Layers = Layers()
    """What is drawn."""
    truth: Tracks | None = None
    """Labels that the tracks are compared with; None: no comparison."""
    scale: float = 1.0
    """Factor on the size of the finished frames, above 0."""
    fitting: Fitting = field(default_factory=Fitting)
    """Finds the shapes for the layer of wireframes."""

    def frames(self, first: int = 0, end: int | None = None) -> Iterator[tuple[int, Image]]:
        """Index and picture of every delivered frame from `first` to before `end`."""
        trails: dict[int, deque[tuple[int, np.ndarray]]] = {}
        for index, standing in expectations(self.drive, self.tracks):
            if end is not None and index >= end:
                return
            self._remember(trails, index, standing)
            if first <= index:
                yield index, self._frame(index, standing, trails)

    def _frame(self, index: int, standing: ExpectedTracks, trails: dict) -> Image:
        parts = [self._title(index), self._view(index, standing)]
        if self.layers.top_view:
            above = self._above(index, standing, trails)
            if self._errors is None:
                above[-len(self._legend) :] = self._legend
                parts.append(above)
            else:
                parts += [above[: -len(self._legend)], self._errors.draw(index), self._legend]
        else:
            parts.append(self._legend)
        frame = np.concatenate(parts)
        if self.scale == 1.0:
            return frame
        how = cv2.INTER_AREA if self.scale < 1.0 else cv2.INTER_CUBIC
        return np.asarray(cv2.resize(frame, None, fx=self.scale, fy=self.scale, interpolation=how))

    def _view(self, index: int, standing: ExpectedTracks) -> Image:
        """The camera's image, or plain ground, with all marks."""
        image = None if self.drive.images is None else self.drive.images.load(index)
        layers, rows = self.layers, self.tracks.select(self.tracks.frames == index)
        if image is None:
            view = plain_ground(self.drive.camera, "no image of this frame")
        else:
            view = image.copy()
        if layers.search_areas:
            draw_areas(view, standing.expected.ids, standing.areas)
        if layers.cuboids:
            draw_cuboids(view, standing.now, self.drive.camera)
        taken: list[Area] = []
        draw_tracks(view, rows, outlines=not layers.cuboids, taken=taken)
        if layers.detections:
            draw_detections(view, self.drive.log.at(index))
        if layers.wireframes:
            time = index / self.drive.frame_rate
            detections = self.drive.log.at(index)
            frame, found = Frame(index, time, detections, image=image), detected(rows, detections)
            seen = self.fitting(frame, self.drive.camera, found)
            draw_wireframes(view, seen, [colour_of_id(each) for each in seen.ids.tolist()])
        if layers.true_wireframes and isinstance(self.drive, SimulatedDrive):
            true = Wireframes.true(self.drive.exact, index)
            draw_wireframes(view, true, [TRUE_COLOUR] * len(true))
        if self._verdicts is not None:
            self._draw_verdicts(view, index, self._verdicts, taken)
        return view

    def _draw_verdicts(
        self, view: Image, index: int, verdicts: Verdicts, taken: list[Area]
    ) -> None:
        def now(tracks: Tracks) -> Tracks:
            return tracks.select(tracks.frames == index)

        found, missed, neutral = (
            now(each) for each in (verdicts.found, verdicts.missed, verdicts.neutral)
        )
        draw_true_boxes(view, found, missed, neutral, taken)
        draw_false(view, now(verdicts.false), taken)
        ages = index - verdicts.switches.frames
        for row in np.flatnonzero((ages >= 0) & (ages < SWITCH_FRAMES)).tolist():
            name = int(verdicts.switches.track_ids[row])
            here = self.tracks.select((self.tracks.frames == index) & (self.tracks.ids == name))
            if len(here):
                old = int(verdicts.switches.old_track_ids[row])
                draw_switch(view, here.boxes[0], old, name, int(ages[row]), taken)

    def _title(self, index: int) -> Image:
        switches = None
        if self._verdicts is not None:
            switches = int((self._verdicts.switches.frames <= index).sum())
        seconds = index / self.drive.frame_rate
        left = title_words(self.drive.name, index, seconds, switches)
        return title(self._width, left, self.tracker_name, self.layers.detections)

    @cached_property
    def _legend(self) -> Image:
        """A bar that says what the marks mean."""
        return legend(self._width, marks(self.layers, self._ground.truth is not None))

    @cached_property
    def _errors(self) -> ErrorStrip | None:
        """The errors over time; None where they are unknown, or not to be shown."""
        truth = self.truth if self.layers.truth else None
        drive = self.drive
        return ErrorStrip.of(
            truth, self.tracks, drive.frame_count, self._width, drive.frame_rate, self._kind
        )

    @property
    def _width(self) -> int:
        return self.drive.camera.image_size[0]

    def _above(self, index: int, standing: ExpectedTracks, trails: dict) -> Image:
        """The top view."""
        ground, camera = self._ground, self.drive.camera
        pose = ground.pose(index)
        view = self._turned(pose) if self.layers.follow else self._still
        panel = view.ground.copy()
        ways = {
            name: np.array([place for _, place in way])
            for name, way in trails.items()
            if way and way[-1][0] == index
        }
        now = standing.now
        centres = ground.on_map(now.cuboids.base[:, ::2], index)
        view.draw_trails(panel, ways)
        view.draw_us(panel, ground.our_outline(index), camera, pose)
        view.draw_truth(panel, ground.true_outlines(index))
        view.draw_doubts(panel, now.ids, centres, ground.cov_on_map(now.cov, index))
        outlines = ground.outlines(now.cuboids, index)
        view.draw_places(panel, now.ids, outlines, now.heading_known)
        return panel

    def _remember(self, trails: dict, index: int, standing: ExpectedTracks) -> None:
        """Add where the tracks are now to their trails; without poses a trail is one point."""
        bases = self._ground.on_map(standing.now.cuboids.base[:, ::2], index)
        for name, base in zip(standing.now.ids.tolist(), bases, strict=True):
            length = 1 if self._ground.poses is None else TRAIL_FRAMES
            trails.setdefault(name, deque(maxlen=length)).append((index, base))

    @cached_property
    def _kind(self) -> str:
        """The class that is judged: that of all tracks; of several, cars."""
        there = [] if self.tracks.kinds is None else np.unique(self.tracks.kinds).tolist()
        return str(there[0]) if len(there) == 1 and there[0] in TRACKED_KINDS else "Car"

    @cached_property
    def _ground(self) -> GroundMap:
        return GroundMap.of(self.drive, self.truth, self._kind)

    @cached_property
    def _verdicts(self) -> Verdicts | None:
        if self.truth is None or not self.layers.truth:
            return None
        return Verdicts.of(self.truth, self.tracks, self.drive.frame_count, self._kind)

    @cached_property
    def _still(self) -> TopView:
        pose = self._ground.pose(int(self.drive.frame_indices[0]))
        return replace(self._turned(pose), heading=0.0)

    def _turned(self, pose: np.ndarray) -> TopView:
        size = (self.drive.camera.image_size[0], TOP_VIEW_PIXELS)
        anchor = (METRES_BEHIND * PIXELS_PER_METRE, 0.5 * TOP_VIEW_PIXELS)
        origin = (float(pose[0]), float(pose[1]))
        return TopView(self._ground.roads, origin, PIXELS_PER_METRE, size, anchor, float(pose[2]))


def detected(tracks: Tracks, detections: Detections) -> Tracks:
    """The tracks whose box overlaps a detection by half; the others are predicted."""
    if not len(detections):
        return tracks.select(slice(0, 0))
    overlap = box_iou(tracks.boxes[:, None], detections.boxes[None])
    return tracks.select((overlap >= MIN_DETECTED_IOU).any(axis=1))

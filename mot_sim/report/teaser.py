"""The first figure of the paper: search areas of frame t, carried into frame t + 1.

Sharma et al., ICRA 2018. `TwoFrames` is what the figure shows; matplotlib draws it, for print.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8
from numpy import ndarray as Array
from scipy.spatial import ConvexHull

from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.files.writing import require_writable, whole_file
from mot_sim.plotting.charts import FIGURE_ENDINGS, require_figure, save_figure
from mot_sim.plotting.colours import colour_of_id, mix
from mot_sim.report.expectations import BelievedPlaces
from mot_sim.report.topview import ellipse
from mot_sim.simulation.truth import project_edges
from tracker import Tracker
from tracker.errors import BadConfig, BadDetections, DatasetNotFound
from tracker.front_end import FrontEnd
from tracker.types import Camera, Cuboids, Frame

PHOTO_ENDINGS = (".jpg", ".jpeg")  # a sixth of a PNG's size
WIDTH_INCHES = 10.0
DOTS_PER_INCH = 200
MAPS_INCHES = 3.1  # height of the two maps
TITLE_INCHES = 0.2  # height of a line of words
METRES_BEHIND = 6.0  # behind the camera, on the maps
MIN_METRES_AHEAD = 25.0  # ahead of it
MAX_METRES_AHEAD = 60.0
OUR_CAR_OUTLINE = np.array(
    [(0.9, -4.2), (0.9, -0.3), (0.0, 0.2), (-0.9, -0.3), (-0.9, -4.2)]
)  # x, z
TEXT_POINTS = 8.0
INK_COLOUR = "#222222"


@dataclass(frozen=True, eq=False)
class TwoFrames:
    """Frames t and t + 1 of a drive, tracked by the two-frame scheme."""

    name: str
    """The drive's name."""
    index: int
    """Index t of the first frame."""
    camera: Camera
    """The camera of both."""
    images: tuple[UInt8[Array, "h w 3"], UInt8[Array, "h w 3"]]
    """RGB images of both."""
    before: BelievedPlaces
    """The cars of frame t, in its road frame."""
    boxes_before: Float[Array, "n 4"]
    """Boxes of the cars of frame t: x_min, y_min, x_max, y_max in px."""
    carried: BelievedPlaces
    """The cars of frame t where they are expected at t + 1, in the road frame of t + 1."""
    regions: Cuboids
    """Cuboids of `carried`, stretched by the uncertainty."""
    seen: BelievedPlaces
    """The cars of frame t + 1, in its road frame; new ones have ids of their own."""
    boxes_seen: Float[Array, "m 4"]
    """Boxes of the cars of frame t + 1: x_min, y_min, x_max, y_max in px."""
    compared: Bool[Array, "n m"]
    """Which pairs (a row of `before`, a row of `seen`) lie in a search area; only their costs are
    computed."""

    @property
    def outlines(self) -> list[Float[Array, "_ 2"]]:
        """The search areas as convex outlines in the image of t + 1, pixels, not clipped."""
        return cuboid_outlines(self.regions, self.camera)


def track_two_frames(
    drive: RecordedSequence, index: int, front_end: FrontEnd | None = None
) -> TwoFrames:
    """Frames `index` and `index` + 1 of a drive, tracked by the paper's two-frame scheme.

    front_end: measures yaw, size and shape in the images. Raises BadConfig for a frame that is
    not there, DatasetNotFound where one has no image, BadDetections where nothing is detected.
    """
    first, second = _frames(drive, index, front_end)
    tracker = replace(Tracker.paper(drive.camera), explain=True)
    tracker.step(replace(first, T_now_before=None, motion_cov=None))
    population = tracker.state.tracks
    if not len(population):
        raise BadDetections(
            f"'{drive.name}' frame {index}: no box with a score of "
            f"{tracker.suppress.min_score:g} or more; choose another frame"
        )
    beliefs = population.beliefs
    before = BelievedPlaces(population.ids, beliefs.cuboids, beliefs.cov[:, :2, :2])
    tracker.step(second)
    assert tracker.explanation is not None
    pairing, matched = tracker.explanation.pairing, tracker.explanation.matched
    expected, observed = pairing.expected, pairing.observed
    compared = np.zeros(pairing.shape, bool)
    compared[pairing.pairs] = True
    assert first.image is not None
    assert second.image is not None
    return TwoFrames(
        drive.name,
        index,
        drive.camera,
        (first.image, second.image),
        before,
        beliefs.boxes,
        BelievedPlaces(population.ids, expected.cuboids, expected.cov[:, :2, :2]),
        pairing.expected_regions,
        BelievedPlaces(_names(matched, population.ids), observed.cuboids, observed.cov[:, :2, :2]),
        observed.boxes,
        compared,
    )


def cuboid_outlines(cuboids: Cuboids, camera: Camera) -> list[Float[Array, "_ 2"]]:
    """The convex outlines of cuboids in the image, pixels; no points for one behind the camera."""
    found = []
    for points in project_edges(cuboids, camera):
        known = points[np.isfinite(points).all(axis=1)]
        hull = known[ConvexHull(known).vertices] if len(known) > 2 else known[:0]
        found.append(hull)
    return found


def _frames(drive: RecordedSequence, index: int, front_end: FrontEnd | None) -> Iterator[Frame]:
    """The two frames with their images, and with cues if there is something to measure them."""
    if not 0 <= index < drive.frame_count - 1:
        raise BadConfig(
            f"frame {index} and the next one: '{drive.name}' has the frames 0 to "
            f"{drive.frame_count - 1}"
        )
    for frame in drive.subset([index, index + 1]):
        if frame.image is None:
            raise DatasetNotFound(
                f"'{drive.name}' has no image of frame {frame.index}, and the figure shows it; "
                "choose another --frame"
            )
        yield frame if front_end is None else front_end(frame, drive.camera)


def _names(matched: Bool[Array, "n m"], ids: Int[Array, " n"]) -> Int[Array, " m"]:
    """The ids of the new detections: of the track they continue, else new ones."""
    columns = matched.shape[1]
    names = np.full(columns, -1)
    rows, found = np.nonzero(matched)
    names[found] = ids[rows]
    new = np.flatnonzero(names < 0)
    names[new] = ids.max(initial=-1) + 1 + np.arange(len(new))
    return names


if TYPE_CHECKING:
    import matplotlib.figure


def draw_teaser(two: TwoFrames) -> "matplotlib.figure.Figure":
    """Two images, t and t + 1, above two maps of the same moments."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - importing mot_sim waits for no plots
    from matplotlib.layout_engine import ConstrainedLayoutEngine  # noqa: PLC0415

    width, height = two.camera.image_size
    row = WIDTH_INCHES * height / width + TITLE_INCHES
    layout = ConstrainedLayoutEngine(h_pad=0.02, w_pad=0.02, hspace=0.02)
    figure = Figure(figsize=(WIDTH_INCHES, 2 * row + MAPS_INCHES), layout=layout)
    parts = figure.subplot_mosaic(
        [["t", "t"], ["next", "next"], ["map t", "map next"]], height_ratios=[row, row, MAPS_INCHES]
    )
    _draw_before(parts["t"], two)
    _draw_after(parts["next"], two)
    reach = _reach(two)
    lifted = f"frame {two.index} from above: lifted to the road, 1 and 2 sigma"
    _draw_map(parts["map t"], two.before, None, lifted, reach)
    _draw_map(
        parts["map next"],
        two.carried,
        two,
        f"frame {two.index + 1}: carried on, search areas dashed, new boxes lifted: black",
        reach,
    )
    return figure


def require_picture(path: Path) -> None:
    """Raise BadConfig for another ending than PNG, JPG, SVG, PDF, BadOutput for no such place."""
    if path.suffix.lower() in PHOTO_ENDINGS:
        require_writable(path)
    elif path.suffix.lower() in FIGURE_ENDINGS:
        require_figure(path)
    else:
        endings = ", ".join((*FIGURE_ENDINGS, *PHOTO_ENDINGS))
        raise BadConfig(f"{path}: give a file that ends in {endings}")


def save_teaser(figure: "matplotlib.figure.Figure", path: Path) -> Path:
    """Write the figure by the file's ending, as a whole or not at all; see `require_picture`."""
    require_picture(path)
    if path.suffix.lower() not in PHOTO_ENDINGS:
        return save_figure(figure, path)
    with whole_file(path) as half:
        figure.savefig(half, format="jpg", dpi=DOTS_PER_INCH, pil_kwargs={"quality": 85})
    return path


def _draw_before(axes: Any, two: TwoFrames) -> None:
    """Frame t: boxes with their numbers, and the cuboids they were lifted to."""
    _show(axes, two.images[0], f"{two.name}, frame {two.index}: boxes, lifted to 3D")
    for track_id, box in zip(two.before.ids.tolist(), two.boxes_before, strict=True):
        colour = _colour(track_id)
        _rectangle(axes, box, edgecolor=colour, linewidth=1.6)
        _number(axes, track_id, (box[0], box[1]))
    _cuboids(axes, two.before.cuboids, two, [_colour(each) for each in two.before.ids.tolist()])


def _draw_after(axes: Any, two: TwoFrames) -> None:
    """Frame t + 1: the search areas in the colours of t, and the new boxes."""
    from matplotlib.patches import Polygon  # noqa: PLC0415

    compared, every = int(two.compared.sum()), two.compared.size
    _show(
        axes,
        two.images[1],
        f"frame {two.index + 1}: where each is expected, and the new boxes; "
        f"{compared} of {every} pairs are compared",
    )
    areas = two.outlines
    for row in np.argsort([-len(area) and -_size(area) for area in areas]).tolist():
        if len(areas[row]):
            colour = _colour(int(two.carried.ids[row]))
            look = {"facecolor": (*colour, 0.28), "edgecolor": (*colour, 0.95), "linewidth": 1.0}
            axes.add_patch(Polygon(areas[row], closed=True, linestyle="--", **look))
    for track_id, box in zip(two.seen.ids.tolist(), two.boxes_seen, strict=True):
        is_old = track_id in two.before.ids
        colour = _colour(track_id) if is_old else (1.0, 1.0, 1.0)
        _rectangle(axes, box, edgecolor="black", linewidth=2.6)
        _rectangle(axes, box, edgecolor=colour, linewidth=1.4)
        if is_old:
            _number(axes, track_id, (box[0], box[1]))


def _draw_map(
    axes: Any, places: BelievedPlaces, two: TwoFrames | None, title: str, reach: tuple[float, float]
) -> None:
    """Places with their ellipses of 1 and 2 standard deviations; regions and new cars of `two`."""
    outlines = places.cuboids.footprint()
    regions = None if two is None else two.regions.footprint()
    for row, track_id in enumerate(places.ids.tolist()):
        colour, centre = _colour(track_id), places.cuboids.base[row, ::2]
        for sigmas, strength in ((2.0, 0.12), (1.0, 0.25)):
            around = ellipse(centre, places.cov[row], sigmas)
            _patch(axes, around, facecolor=(*colour, strength), linewidth=0)
            width = 0.45 * sigmas**-0.5
            _patch(axes, around, edgecolor=_dark(colour), zorder=3, linewidth=width)
        if regions is not None:
            _patch(axes, regions[row], edgecolor=colour, linestyle="--", linewidth=1.0)
        filled = (*colour, 0.40)
        _patch(axes, outlines[row], facecolor=filled, edgecolor=colour, linewidth=1.2)
        style = {"ha": "center", "va": "center", "fontsize": TEXT_POINTS - 1.5, "clip_on": True}
        axes.text(*_ahead(centre), str(track_id), color=INK_COLOUR, **style)
    for corners in () if two is None else two.seen.cuboids.footprint():
        _patch(axes, corners, edgecolor="black", linewidth=0.9, zorder=4)
    _patch(axes, OUR_CAR_OUTLINE, facecolor="#555555", linewidth=0)
    _set_map_axes(axes, title, reach)


def _set_map_axes(axes: Any, title: str, reach: tuple[float, float]) -> None:
    """Limits, grid and title of a map. reach: metres ahead and to either side."""
    far, side = reach
    axes.set_xlim(-METRES_BEHIND, far)
    axes.set_ylim(-side, side)
    axes.set_aspect("equal")
    axes.grid(color="#e4e4e4", linewidth=0.5)
    axes.set_axisbelow(True)
    axes.set_xlabel("metres ahead", fontsize=TEXT_POINTS)
    axes.tick_params(labelsize=TEXT_POINTS - 1, length=2)
    axes.set_title(title, loc="left", fontsize=TEXT_POINTS + 0.5)


def _patch(axes: Any, points: Float[Array, "n 2"], **look: Any) -> None:
    """A polygon on a map; not filled unless `look` says so."""
    from matplotlib.patches import Polygon  # noqa: PLC0415

    axes.add_patch(Polygon(_ahead(points), **{"facecolor": "none", **look}))


def _reach(two: TwoFrames) -> tuple[float, float]:
    """How far ahead, and to either side, the maps must show."""
    bases = np.concatenate((two.before.cuboids.base, two.carried.cuboids.base))
    shape = (MAPS_INCHES - 0.9) / (0.5 * WIDTH_INCHES - 0.6)  # of a map, without its words
    far = float(np.clip(bases[:, 2].max(initial=0.0) + 8.0, MIN_METRES_AHEAD, MAX_METRES_AHEAD))
    near = bases[bases[:, 2] < far]
    side = float(np.abs(near[:, 0]).max(initial=0.0)) + 3.0
    far = float(np.clip(2.0 * side / shape - METRES_BEHIND, far, MAX_METRES_AHEAD))
    return far, 0.5 * (far + METRES_BEHIND) * shape


def _cuboids(axes: Any, cuboids: Cuboids, two: TwoFrames, colours: list) -> None:
    """The twelve edges of cuboids in the image."""
    edges = project_edges(cuboids, two.camera)
    for points, colour in zip(edges, colours, strict=True):
        for start, end in zip(points[:12], points[12:], strict=True):
            if np.isfinite(start).all() and np.isfinite(end).all():
                u, v = np.stack((start, end), axis=1)
                axes.plot(u, v, color="black", linewidth=1.5, alpha=0.5)
                axes.plot(u, v, color=colour, linewidth=0.9)


def _show(axes: Any, image: Array, title: str) -> None:
    height, width = image.shape[:2]
    axes.imshow(image, interpolation="antialiased")
    axes.set_xlim(-0.5, width - 0.5)
    axes.set_ylim(height - 0.5, -0.5)
    axes.set_axis_off()
    axes.set_title(title, loc="left", fontsize=TEXT_POINTS + 0.5)


def _rectangle(axes: Any, box: Float[Array, "4"], **look: Any) -> None:
    from matplotlib.patches import Rectangle  # noqa: PLC0415

    left, top, right, bottom = box.tolist()
    axes.add_patch(Rectangle((left, top), right - left, bottom - top, fill=False, **look))


def _number(axes: Any, track_id: int, place: tuple[float, float]) -> None:
    """An id on its colour, at the upper left corner of a box."""
    colour = _colour(track_id)
    light = 0.299 * colour[0] + 0.587 * colour[1] + 0.114 * colour[2] > 0.55
    box = {"facecolor": colour, "edgecolor": "none", "pad": 1.2}
    style = {"va": "bottom", "ha": "left", "fontsize": TEXT_POINTS - 1.0, "clip_on": True}
    u, v = max(place[0], 2.0), max(place[1], 12.0) - 2.0
    axes.text(u, v, str(track_id), color="black" if light else "white", bbox=box, **style)


def _ahead(points: Float[Array, "*n 2"]) -> Float[Array, "*n 2"]:
    """From (x right, z ahead) to a map whose right is ahead and whose upper half is to our left."""
    return np.stack((points[..., 1], -points[..., 0]), axis=-1)


def _dark(colour: tuple[float, float, float]) -> tuple[float, float, float]:
    red, green, blue = colour
    return 0.55 * red, 0.55 * green, 0.55 * blue


def _size(outline: Float[Array, "n 2"]) -> float:
    return float(np.ptp(outline, axis=0).prod())


def _colour(track_id: int) -> tuple[float, float, float]:
    """The colour of an id, a little darker than on the screen."""
    red, green, blue = mix(colour_of_id(track_id), (0, 0, 0), 0.08)
    return red / 255, green / 255, blue / 255

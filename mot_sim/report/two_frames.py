"""Two frames as the paper's tracker sees them: lifted, carried on, and looked for.

Sharma et al., ICRA 2018: what their first figure and the figure of the 3D-2D cost show.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8
from numpy import ndarray as Array
from scipy.spatial import ConvexHull

from mot_sim.datasets.recorded import RecordedSequence
from mot_sim.report.expectations import BelievedPlaces
from mot_sim.simulation.truth import project_edges
from tracker import Tracker
from tracker.errors import BadConfig, BadDetections, DatasetNotFound
from tracker.front_end import FrontEnd
from tracker.types import Camera, Cuboids, Frame


@dataclass(frozen=True, eq=False)
class TwoFrames:
    """Frame t and frame t + 1.

    images: of both. before, boxes_before: the cars of frame t, in its road frame and image.
    carried: where they are expected at t + 1, in its road frame; regions: those cuboids stretched
    by the uncertainty. seen, boxes_seen, ids_seen: the cars of t + 1; new ones have ids of their
    own. compared: which pairs (of before, of seen) lie in a search area, the only ones whose costs
    are computed.
    """

    name: str
    index: int
    camera: Camera
    images: tuple[UInt8[Array, "h w 3"], UInt8[Array, "h w 3"]]
    before: BelievedPlaces
    boxes_before: Float[Array, "n 4"]
    carried: BelievedPlaces
    regions: Cuboids
    seen: BelievedPlaces
    boxes_seen: Float[Array, "m 4"]
    compared: Bool[Array, "n m"]

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


__all__ = ["TwoFrames", "cuboid_outlines", "track_two_frames"]

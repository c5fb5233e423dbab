"""Ground truth from rendered pixels: what no detector sees, apart from every `Frame`."""

from mot_sim.simulation.truth.annotate import Annotations, annotate, annotate_frame
from mot_sim.simulation.truth.cuboid_boxes import (
    boxes_around,
    boxes_in_image,
    project_edges,
    truncation_of,
)
from mot_sim.simulation.truth.events import EVENTS, Events, find_events
from mot_sim.simulation.truth.labels import labels
from mot_sim.simulation.truth.table import (
    KeypointVisibility,
    Occlusions,
    Truth,
    occlusion_level,
)

__all__ = [
    "EVENTS",
    "Annotations",
    "Events",
    "KeypointVisibility",
    "Occlusions",
    "Truth",
    "annotate",
    "annotate_frame",
    "boxes_around",
    "boxes_in_image",
    "find_events",
    "labels",
    "occlusion_level",
    "project_edges",
    "truncation_of",
]

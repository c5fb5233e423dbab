"""The state of a car behind its boxes: place, heading, speed and size, with their uncertainty."""

from tracker.car_filter.carried_boxes import carried_boxes, expected_after
from tracker.car_filter.cues import CarCues, CueModel
from tracker.car_filter.edges import EdgeModel, border_gaps
from tracker.car_filter.filter import CarFilter
from tracker.car_filter.motion import CarMotion
from tracker.car_filter.projection import project_boxes
from tracker.car_filter.road_memory import DirectionPrior, RoadMemory, RoadModel
from tracker.car_filter.smoothing import (
    FilteredFrame,
    FollowedCars,
    SeenCars,
    follow_cars,
    smooth_cars,
    smooth_first,
)
from tracker.car_filter.states import CarStates

__all__ = [
    "CarCues", "CarFilter", "CarMotion", "CarStates", "CueModel", "DirectionPrior", "EdgeModel",
    "FilteredFrame", "FollowedCars", "RoadMemory", "RoadModel", "SeenCars",
    "border_gaps", "carried_boxes", "expected_after", "follow_cars", "project_boxes",
    "smooth_cars", "smooth_first",
]  # fmt: skip

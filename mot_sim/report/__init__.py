"""What people look at: frames, videos, tables."""

from mot_sim.report.captions import Layers
from mot_sim.report.drawing import draw_detections, draw_tracks
from mot_sim.report.film import Film
from mot_sim.report.topview import TopView
from mot_sim.report.video import FilmWriter, write_image, write_video

__all__ = [
    "Film",
    "FilmWriter",
    "Layers",
    "TopView",
    "draw_detections",
    "draw_tracks",
    "write_image",
    "write_video",
]

"""Drawing: canvas, colours, charts, films; it knows nothing of experiments."""

from mot_sim.plotting.drawing import draw_detections, draw_tracks
from mot_sim.plotting.video import FilmWriter, write_image, write_video

__all__ = [
    "FilmWriter",
    "draw_detections",
    "draw_tracks",
    "write_image",
    "write_video",
]

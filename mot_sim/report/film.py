"""The frames of an episode as people see them: title, camera view with tracks, top view."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mot_sim.episode import Episode
from mot_sim.report.canvas import Image, text, text_width
from mot_sim.report.colours import PANEL, PANEL_FAINT, PANEL_TEXT
from mot_sim.report.drawing import draw_detections, draw_tracks
from mot_sim.report.topview import Point, TopView, road_contacts, trails_until
from tracker.types import Tracks

TITLE = 32  # pixels
TOP_VIEW = 313  # pixels: with KITTI's 375 and the title it makes 720
SCALE = 7.8  # pixels a metre in the top view
BEHIND = 14.0  # metres behind where we start, in the top view
TRAIL = 25  # frames
LEGEND = (
    "from above: true outlines white; trails where the tracks' boxes meet the road, mean of .5 s"
)


@dataclass(frozen=True, eq=False)
class Film:
    """Frames of 1242 x 720 pixels for KITTI's camera, drawn one by one when asked for."""

    episode: Episode
    tracks: Tracks
    tracker_name: str = "default"

    def __len__(self) -> int:
        return self.episode.frame_count

    def frame(self, index: int) -> Image:
        """One frame: title, camera view, top view."""
        episode = self.episode
        scene, world = episode.scene, episode.worlds[index]
        view = self._image(index)
        draw_tracks(view, self.tracks.select(self.tracks.frames == index))
        draw_detections(view, episode.log.at(index))
        trails = trails_until(self._contacts, index, TRAIL)
        above = self._top_view.draw(world, scene.rig, trails)
        text(above, LEGEND, (12, above.shape[0] - 10), PANEL_TEXT, 14)
        return np.concatenate((self._title(index), view, above))

    def _image(self, index: int) -> Image:
        """The camera's image; black where the episode has none."""
        images = self.episode.images
        found = None if images is None else images.load(index)
        if found is None:
            width, height = self.episode.camera.image_size
            return np.zeros((height, width, 3), np.uint8)
        return found.copy()

    def _title(self, index: int) -> Image:
        """The bar with the frame number."""
        bar = np.empty((TITLE, self.episode.camera.image_size[0], 3), np.uint8)
        bar[:] = PANEL
        seconds = self.episode.worlds[index].time
        words = f"{self.episode.name}   frame {index:03d}   {seconds:4.1f} s"
        text(bar, words, (12, 22), PANEL_TEXT, 18)
        legend = f"thin grey: detections   colour and number: tracks of '{self.tracker_name}'"
        text(bar, legend, (bar.shape[1] - text_width(legend, 15) - 12, 22), PANEL_FAINT, 15)
        return bar

    @cached_property
    def _top_view(self) -> TopView:
        first = self.episode.worlds[0].ego
        origin = (float(first[0]) - BEHIND, float(first[1]) - 0.5 * TOP_VIEW / SCALE)
        size = (self.episode.camera.image_size[0], TOP_VIEW)
        return TopView(self.episode.scene.roads, origin, SCALE, size)

    @cached_property
    def _contacts(self) -> dict[int, dict[int, Point]]:
        egos = {frame: world.ego for frame, world in enumerate(self.episode.worlds)}
        return road_contacts(self.tracks, self.episode.scene.rig, egos)

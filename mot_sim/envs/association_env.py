"""Data association as a Gymnasium environment: who is who, decided a frame at a time.

The return of an episode is its MOTA (Bernardin & Stiefelhagen, EURASIP 2008, as TrackEval counts
KITTI's cars) for immediate output without filled gaps.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from jaxtyping import Int
from numpy import ndarray as Array

from mot_sim.envs.asking import ForcedAssociation, forced_tracker
from mot_sim.envs.counting import RunningClear, counted_labels
from mot_sim.envs.errors import OutOfTurn, require_action, require_options
from mot_sim.envs.factory import scene_made
from mot_sim.envs.observing import (
    Observation,
    box_space,
    pad,
    pad_boxes,
    require_padding,
    surest,
)
from mot_sim.envs.resuming import ReplayPickle
from mot_sim.envs.slots import Slots, decide
from mot_sim.envs.sources import EpisodeSource, FolderSource, SceneSource
from mot_sim.simulation.scene import Knob
from tracker import Tracks
from tracker.association import Hungarian
from tracker.errors import BadConfig
from tracker.types import Detections, Frame


class AssociationEnv(ReplayPickle, gym.Env[Observation, Any]):
    """Recorded episodes, in which the action says what becomes of every detection of a frame.

    Action: for each detection a track's slot (0 to max_tracks - 1), `new` (max_tracks) or
    `reject` (max_tracks + 1); beyond the detections that are there it says nothing. Of two
    detections on one track the dearer loses and is rejected (of equal costs the later one).
    Rejected are also those on an empty slot, on a track where they are not `possible`, and new
    ones when no slot is free; info counts them all as `refused`.

    Observation: `costs` (max_tracks, max_detections), the tracker's, clipped to [0, 1], 1 where
    not `possible`, which marks the pairs inside the search areas; `tracks`, the slots that are
    taken; `boxes` and `scores` of the detections, and `detections`, their mask. Detections are
    those that the tracker does not suppress, of too many the surest. Reward: TP - FP - IDSW of
    the frame, over the boxes of the episode that must be found, at least 1. Tracks die as the
    tracker's lifecycle says. The episode terminates after its last frame, with nothing to see.

    scene, knobs: whose episodes of seeds 0 to pool - 1 are recorded when they are drawn, and
    kept. episodes: a folder of recorded ones instead. tracker: of TRACKERS, whose suppression,
    costs and memory are used. info: `episode` (its number), `frame`, `refused`, and CLR_TP,
    CLR_FP, CLR_FN, IDSW and MOTA so far. Raises UnknownName, BadConfig, DatasetNotFound.
    """

    # gym.make reads the class's; an instance has its own copy.
    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        scene: str = "crossing",
        *,
        episodes: str | None = None,
        pool: int = 16,
        tracker: str = "default",
        max_detections: int = 64,
        max_tracks: int = 64,
        render_mode: str | None = None,
        **knobs: Knob,
    ) -> None:
        self._arguments = {
            "scene": scene, "episodes": episodes, "pool": pool, "tracker": tracker,
            "max_detections": max_detections, "max_tracks": max_tracks,
            "render_mode": render_mode, **knobs,
        }  # fmt: skip
        require_padding("max_detections", max_detections)
        require_padding("max_tracks", max_tracks)
        if render_mode is not None:
            raise BadConfig(f"render_mode {render_mode!r}: nothing is drawn here; give None")
        self.metadata, self.render_mode = {"render_modes": []}, None
        self.max_detections, self.max_tracks = max_detections, max_tracks
        self._source: EpisodeSource = _source_of(scene, episodes, pool, knobs)
        self._told = ForcedAssociation()
        self._tracker = forced_tracker(tracker, self._source.camera, self._told)
        self._episode: int | None = None
        self._actions: list[Any] = []
        self.observation_space = spaces.Dict({
            "costs": spaces.Box(0.0, 1.0, (max_tracks, max_detections), np.float64),
            "possible": spaces.MultiBinary((max_tracks, max_detections)),
            "tracks": spaces.MultiBinary(max_tracks),
            "boxes": box_space(self._source.camera, max_detections),
            "scores": spaces.Box(0.0, 1.0, (max_detections,), np.float64),
            "detections": spaces.MultiBinary(max_detections),
        })  # fmt: skip
        self.action_space = spaces.MultiDiscrete(np.full(max_detections, max_tracks + 2))

    @property
    def tracks(self) -> Tracks:
        """What was put out in this episode so far."""
        return Tracks.concatenate([Tracks.empty(), *self._rows])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The first frame of an episode that is drawn, or of options' `episode`, its number.

        Raises UnknownName for other options, BadConfig for a number that is not there.
        """
        super().reset(seed=seed)
        chosen = require_options(options, ("episode",)).get("episode")
        number = int(self.np_random.integers(len(self._source)) if chosen is None else chosen)
        if not 0 <= number < len(self._source):
            raise BadConfig(f"episode {number}: there are 0 to {len(self._source) - 1}")
        self._begin(number)
        return self._observe(), self._tell()

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Decide on a frame; the next one. Raises OutOfTurn and BadAction."""
        if self._episode is None:
            raise OutOfTurn("nothing has begun: call reset() first")
        if self._is_over:
            raise OutOfTurn(f"a step after the end, frame {len(self._actions)}: call reset() first")
        meaning = (
            f"give {self.max_detections} numbers: slots 0 to {self.max_tracks - 1}, "
            f"{self.max_tracks} for a new track, {self.max_tracks + 1} to reject"
        )
        require_action(self.action_space, action, meaning)
        before = self._clear.total.gain
        self._advance(np.array(action))
        reward = (self._clear.total.gain - before) / self._labelled
        return self._observe(), reward, self._is_over, False, self._tell()

    @property
    def _is_over(self) -> bool:
        return len(self._actions) >= len(self._frames)

    def _begin(self, episode: int) -> None:
        """Play an episode from its beginning."""
        drive = self._source.load(episode)
        self._episode, self._actions = episode, []
        self._frames, self._truth = list(drive), drive.truth
        self._labelled = max(1, counted_labels(drive.truth, drive.frame_count))
        self._clear, self._rows, self._refused = RunningClear(), list[Tracks](), 0
        self._slots = Slots.empty(self.max_tracks)
        self._tracker.reset()
        self._ask()

    def _ask(self) -> None:
        """What the tracker would be asked to match in this frame; nothing is done yet."""
        if self._is_over:
            self._told.costs = np.zeros((0, 0))
            return
        frame = self._frames[len(self._actions)]
        kept = self._tracker.suppress(frame.detections, self._tracker.camera)
        self._frame: Frame = replace(frame, detections=surest(kept, self.max_detections))
        state, self._told.match = self._tracker.state, None
        self._tracker.step(self._frame)
        self._tracker.state = state

    def _advance(self, action: Int[Array, " m"]) -> None:
        """Match as told; count what comes out."""
        costs, index = self._told.costs, self._frame.index
        slots = self._slots.of(self._tracker.state.tracks.ids)
        told = action[: costs.shape[1]]
        self._told.match, self._refused = decide(told, costs, slots, self.max_tracks)
        rows = self._tracker.step(self._frame)
        self._slots = self._slots.after(self._tracker.state.tracks.ids)
        first, last = np.searchsorted(self._truth.frames, [index, index + 1]).tolist()
        self._clear.add(self._truth.select(slice(first, last)), rows, index)
        self._rows.append(rows)
        self._actions.append(action)
        self._ask()

    def _observe(self) -> Observation:
        """The tracks and detections of this frame, and what each pair costs."""
        asked = self._told.costs
        costs = np.full((self.max_tracks, self.max_detections), np.inf)
        seen = Detections.empty()
        if not self._is_over:
            slots = self._slots.of(self._tracker.state.tracks.ids)
            costs[slots, : asked.shape[1]] = asked
            seen = self._frame.detections
        return {
            "costs": costs.clip(0.0, 1.0),
            "possible": np.isfinite(costs).astype(np.int8),
            "tracks": (self._slots.taken & (not self._is_over)).astype(np.int8),
            "boxes": pad_boxes(seen.boxes, self._source.camera, self.max_detections),
            "scores": pad(seen.scores.clip(0.0, 1.0), self.max_detections),
            "detections": pad(np.ones(len(seen), np.int8), self.max_detections),
        }

    def _tell(self) -> dict[str, Any]:
        """The same keys after every step."""
        total = self._clear.total
        told = {"episode": self._episode, "frame": len(self._actions), "refused": self._refused}
        return {**told, **vars(total), "MOTA": total.MOTA}


def hungarian_policy(
    observation: Observation, max_cost: float = 1.0, birth_score: float = 0.0
) -> Int[Array, " m"]:
    """The action that matches at the least cost, and begins tracks with the other detections.

    max_cost: pairs that cost as much are never made. birth_score: of detections that may begin
    a track; the others are rejected.
    """
    slots, there = np.flatnonzero(observation["tracks"]), observation["detections"].astype(bool)
    table = np.ix_(slots, np.flatnonzero(there))
    costs = np.where(observation["possible"][table], observation["costs"][table], np.inf)
    match = Hungarian(max_cost)(costs)
    new, reject = len(observation["tracks"]), len(observation["tracks"]) + 1
    action = np.where(there & (observation["scores"] >= birth_score), new, reject)
    action[match.pairs[:, 1]] = slots[match.pairs[:, 0]]
    return action.astype(np.int64)


def _source_of(
    scene: str, episodes: str | None, pool: int, knobs: dict[str, Knob]
) -> EpisodeSource:
    """A folder's episodes, or a scene's."""
    if episodes is None:
        return SceneSource(scene_made(scene, tuple(sorted(knobs.items()))), pool)
    if knobs:
        raise BadConfig(f"episodes of a folder have no knobs left to turn: drop {sorted(knobs)}")
    return FolderSource.find(Path(episodes))


__all__ = ["AssociationEnv", "hungarian_policy"]

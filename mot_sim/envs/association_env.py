"""Data association as a Gymnasium environment: who is who, decided a frame at a time.

The return of an episode is its MOTA (Bernardin & Stiefelhagen, EURASIP 2008, as TrackEval counts
KITTI's cars) for immediate output without filled gaps.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from mot_sim.envs.episode_sources import EpisodeSource, FolderSource, SceneSource
from mot_sim.envs.errors import OutOfTurn, require_action, require_options
from mot_sim.envs.observations import (
    Observation,
    box_space,
    pad,
    pad_boxes,
    require_padding,
    surest,
)
from mot_sim.envs.rollouts import ReplayPickle, scene_made
from mot_sim.envs.wrappers import RunningClear, counted_labels
from mot_sim.files.named_objects import make_tracker, without_own_name
from mot_sim.simulation.scene import Knob
from tracker import CostMatrix, Tracker, Tracks
from tracker.association import Hungarian, Match
from tracker.errors import BadConfig
from tracker.types import Detections, Frame

EMPTY_SLOT = -1  # the id in a slot without a track


class AssociationEnv(ReplayPickle, gym.Env[Observation, Any]):
    """Recorded episodes, in which the action says what becomes of every detection of a frame.

    Action: for each detection a track's slot (0 to max_tracks - 1), `new` (max_tracks) or
    `reject` (max_tracks + 1); entries beyond the detections are ignored. Of two detections on
    one track the one with the larger cost is rejected (of equal costs the later one).
    Rejected are also those on an empty slot, on a track where they are not `possible`, and new
    ones when no slot is free; info counts them all as `refused`.

    Observation: `costs` (max_tracks, max_detections), the tracker's, clipped to [0, 1], 1 where
    not `possible`, which marks the pairs inside the search areas; `tracks`, the slots that are
    taken; `boxes` and `scores` of the detections, and `detections`, their mask. Detections are
    those that the tracker does not suppress, of too many the surest. Reward: TP - FP - IDSW of
    the frame, over the boxes of the episode that must be found, at least 1. Tracks die as the
    tracker's lifecycle says. The episode terminates after its last frame, with nothing to see.

    scene, knobs: the episodes of seeds 0 to pool - 1 are recorded when they are drawn, and kept.
    episodes: a folder of recorded ones instead. tracker: of TRACKERS, whose suppression, costs
    and memory are used. info: `episode` (its number), `frame`, `refused`, and CLR_TP,
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
            "scene": scene,
            "episodes": episodes,
            "pool": pool,
            "tracker": tracker,
            "max_detections": max_detections,
            "max_tracks": max_tracks,
            "render_mode": render_mode,
            **knobs,
        }
        require_padding("max_detections", max_detections)
        require_padding("max_tracks", max_tracks)
        if render_mode is not None:
            raise BadConfig(f"render_mode {render_mode!r}: nothing is drawn here; give None")
        self.metadata, self.render_mode = {"render_modes": []}, None
        self.max_detections, self.max_tracks = max_detections, max_tracks
        self._source: EpisodeSource = _source_of(scene, episodes, pool, knobs)
        ours: Tracker = make_tracker(without_own_name(tracker), self._source.camera, Tracker)
        # Tracks begin where the action says so, whatever the score.
        self._tracker = replace(ours, lifecycle=replace(ours.lifecycle, birth_score=-np.inf))
        self._episode: int | None = None
        self._actions: list[Any] = []
        self.observation_space = spaces.Dict(
            {
                "costs": spaces.Box(0.0, 1.0, (max_tracks, max_detections), np.float64),
                "possible": spaces.MultiBinary((max_tracks, max_detections)),
                "tracks": spaces.MultiBinary(max_tracks),
                "boxes": box_space(self._source.camera, max_detections),
                "scores": spaces.Box(0.0, 1.0, (max_detections,), np.float64),
                "detections": spaces.MultiBinary(max_detections),
            }
        )
        self.action_space = spaces.MultiDiscrete(np.full(max_detections, max_tracks + 2))

    @property
    def tracks(self) -> Tracks:
        """The rows of this episode so far."""
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
        return self._observe(), self._info()

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
        return self._observe(), reward, self._is_over, False, self._info()

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
        self._compare()

    def _compare(self) -> None:
        """The next frame, and what its detections cost; nothing is decided yet."""
        if self._is_over:
            return
        frame = self._frames[len(self._actions)]
        kept = self._tracker.suppress(frame.found, self._tracker.camera)
        seen = surest(kept, self.max_detections) if frame.looked_at else None
        self._frame: Frame = replace(frame, detections=seen)
        self._compared: CostMatrix = self._tracker.cost_matrix(self._frame)

    def _advance(self, action: Int[Array, " m"]) -> None:
        """Match as the action says; count the rows of the frame."""
        compared, index = self._compared, self._frame.index
        slots = self._slots.of(compared.tracks.ids)
        decisions = action[: len(compared.detections)]
        match, self._refused = decide(decisions, compared.costs, slots, self.max_tracks)
        rows = self._tracker.apply_match(self._frame, compared, match)
        self._slots = self._slots.after(self._tracker.state.tracks.ids)
        first, last = np.searchsorted(self._truth.frames, [index, index + 1]).tolist()
        self._clear.add(self._truth.select(slice(first, last)), rows, index)
        self._rows.append(rows)
        self._actions.append(action)
        self._compare()

    def _observe(self) -> Observation:
        """The tracks and detections of this frame, and what each pair costs."""
        costs = np.full((self.max_tracks, self.max_detections), np.inf)
        seen = Detections.empty()
        if not self._is_over:
            seen = self._compared.detections
            slots = self._slots.of(self._compared.tracks.ids)
            costs[slots, : len(seen)] = self._compared.costs
        return {
            "costs": costs.clip(0.0, 1.0),
            "possible": np.isfinite(costs).astype(np.int8),
            "tracks": (self._slots.taken & (not self._is_over)).astype(np.int8),
            "boxes": pad_boxes(seen.boxes, self._source.camera, self.max_detections),
            "scores": pad(seen.scores.clip(0.0, 1.0), self.max_detections),
            "detections": pad(np.ones(len(seen), np.int8), self.max_detections),
        }

    def _info(self) -> dict[str, Any]:
        """The same keys after every step."""
        total = self._clear.total
        now = {"episode": self._episode, "frame": len(self._actions), "refused": self._refused}
        return {**now, **vars(total), "MOTA": total.MOTA}


@dataclass(frozen=True, eq=False)
class Slots:
    """Which track is in which slot; a track keeps its slot."""

    ids: Int[Array, " s"]
    """Id of the track in every slot; EMPTY_SLOT where there is none."""

    @classmethod
    def empty(cls, count: int) -> "Slots":
        """No track in any slot."""
        return cls(np.full(count, EMPTY_SLOT))

    @property
    def taken(self) -> Bool[Array, " s"]:
        """Which slots hold a track."""
        return self.ids != EMPTY_SLOT

    def of(self, ids: Int[Array, " n"]) -> Int[Array, " n"]:
        """The slots of tracks that have one."""
        order = np.argsort(self.ids, kind="stable")
        return order[np.searchsorted(self.ids[order], ids)]

    def after(self, living: Int[Array, " n"]) -> "Slots":
        """The slots once only these tracks live; those without one take the lowest free ones."""
        ids = np.where(np.isin(self.ids, living), self.ids, EMPTY_SLOT)
        new = living[~np.isin(living, ids)]
        ids[np.flatnonzero(ids == EMPTY_SLOT)[: len(new)]] = new
        return Slots(ids)


def decide(
    action: Int[Array, " m"], costs: Float[Array, "n m"], slots: Int[Array, " n"], slot_count: int
) -> tuple[Match, int]:
    """The match that an action stands for, and how many detections it could not place.

    action: for each detection a slot, slot_count for a new track, slot_count + 1 for none.
    costs: of the tracks, whose slots are given, with the detections; inf = impossible.
    """
    rows_of = np.full(slot_count + 2, EMPTY_SLOT)
    rows_of[slots] = np.arange(len(slots))
    best: dict[int, int] = {}
    refused = 0
    for column in np.flatnonzero(action < slot_count).tolist():
        row = int(rows_of[action[column]])
        if row == EMPTY_SLOT or not np.isfinite(costs[row, column]):
            refused += 1
        elif row not in best:
            best[row] = column
        else:
            refused += 1
            if costs[row, column] < costs[row, best[row]]:
                best[row] = column
    new = np.flatnonzero(action == slot_count)
    free = slot_count - len(slots)
    pairs = np.array(sorted(best.items()), np.int64).reshape(-1, 2)
    lost = np.setdiff1d(np.arange(len(slots)), pairs[:, 0])
    return Match(pairs, lost, new[:free]), refused + max(0, len(new) - free)


def hungarian_policy(
    observation: Observation, max_cost: float = 1.0, birth_score: float = 0.0
) -> Int[Array, " m"]:
    """The action that matches at the least cost, and begins tracks with the other detections.

    max_cost: pairs that cost as much or more are never made. birth_score: detections from it on
    begin tracks; the others are rejected.
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

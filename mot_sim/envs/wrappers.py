"""Wrappers of scene environments (tracks in the observation, running scores in the info).

The scores are counted frame by frame, by CLEAR: the counts that the whole sequence would give so
far.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs

from mot_sim.envs.observations import (
    Observation,
    observe_tracks,
    require_padding,
    track_space,
)
from mot_sim.envs.rollouts import FrameTruth
from mot_sim.files.named_objects import without_own_name
from mot_sim.foreign.protocol import Steps, as_steps, make_steps
from mot_sim.metrics import evaluate_sequence
from mot_sim.metrics.clear import CONTINUING_BONUS
from mot_sim.metrics.matching import EPSILON, Overlaps, solve_frame
from mot_sim.metrics.preprocessing import MIN_OVERLAP, counted_output, prepare_sequence
from mot_sim.simulation.truth import Truth, labels
from tracker import Camera, Frame, Tracker, Tracks
from tracker.errors import BadConfig

Step = tuple[Observation, Any, bool, bool, dict[str, Any]]
TRACKS_KEY = "tracks"


class TrackObservation(gym.Wrapper[Observation, Any, Observation, Any], RecordConstructorArgs):
    """Adds `tracks` (boxes, ids, mask) to the observation: what a tracker makes of the frames.

    tracker: a name, as for `mot-sim sweep --trackers` without settings, or what builds a tracker
    for a camera; see `mot_sim.foreign.protocol.as_steps` for what that may be. The rows of this
    moment are `env.tracks`.
    """

    def __init__(
        self,
        env: gym.Env[Observation, Any],
        tracker: str | Callable[[Camera], Any] = "default",
        max_tracks: int = 64,
    ) -> None:
        RecordConstructorArgs.__init__(self, tracker=tracker, max_tracks=max_tracks)
        super().__init__(env)
        require_padding("max_tracks", max_tracks)
        self.max_tracks = max_tracks
        self.seen_by: Camera = env.get_wrapper_attr("camera")
        self.made_by = tracker
        self.tracker = self._made()
        self.tracks = Tracks.empty()
        space = env.observation_space
        if not isinstance(space, spaces.Dict):
            raise BadConfig(f"observations of {space} hold no tracks: wrap a scene environment")
        self.observation_space = spaces.Dict(
            {**space.spaces, TRACKS_KEY: track_space(self.seen_by, max_tracks)}
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The first frame of a new episode; the tracker has forgotten the last one."""
        observation, info = self.env.reset(seed=seed, options=options)
        if isinstance(self.tracker, Tracker):
            self.tracker.reset()
        else:
            self.tracker = self._made()
        return self._track(observation), info

    def _made(self) -> Steps:
        """A tracker that knows nothing yet."""
        if isinstance(self.made_by, str):
            return make_steps(without_own_name(self.made_by), self.seen_by)
        return as_steps(self.made_by(self.seen_by), getattr(self.made_by, "__name__", "tracker"))

    def step(self, action: Any) -> Step:
        """The next frame, tracked."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self._track(observation), reward, terminated, truncated, info

    def _track(self, observation: Observation) -> Observation:
        frame: Frame = self.env.get_wrapper_attr("frame")
        self.tracks = self.tracker.step(frame)
        seen = observe_tracks(self.tracks, self.seen_by, self.max_tracks)
        return {**observation, TRACKS_KEY: seen}


class Scored(gym.Wrapper[Observation, Any, Observation, Any], RecordConstructorArgs):
    """Adds to the info the scores of the tracks of a wrapped `TrackObservation`.

    `scores`: CLR_TP, CLR_FP, CLR_FN, IDSW and MOTA of the episode so far, counted frame by
    frame by the labels of each frame. `final_scores`: at the end of an episode all of
    `mot_sim.metrics` (HOTA, CLEAR, Identity) as a `ScoreNoise`, by the labels of the whole run
    (those keep cars that hide for a moment); None before.
    """

    def __init__(self, env: gym.Env[Observation, Any]) -> None:
        RecordConstructorArgs.__init__(self)
        super().__init__(env)
        if not env.has_wrapper_attr(TRACKS_KEY):
            raise BadConfig("there are no tracks to score: wrap in TrackObservation before")
        self.clear = RunningClear()
        self.exact: list[Truth] = []
        self.rows: list[Tracks] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The first frame of a new episode, counted from nothing."""
        observation, info = self.env.reset(seed=seed, options=options)
        self.clear, self.exact, self.rows = RunningClear(), [], []
        return observation, self._score(info, False)

    def step(self, action: Any) -> Step:
        """The next frame, counted."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        is_last = terminated or truncated
        return observation, reward, terminated, truncated, self._score(info, is_last)

    def _score(self, info: dict[str, Any], is_last: bool) -> dict[str, Any]:
        truth: FrameTruth = info["truth"]
        tracks: Tracks = self.env.get_wrapper_attr(TRACKS_KEY)
        self.exact.append(truth.exact)
        self.rows.append(tracks)
        self.clear.add(truth.labels, tracks, len(self.rows) - 1)
        scores = {**vars(self.clear.total), "MOTA": self.clear.total.MOTA}
        final = None
        if is_last:
            labelled = labels(Truth.concatenate(self.exact))
            final = evaluate_sequence(labelled, Tracks.concatenate(self.rows), len(self.rows))
        return {**info, "scores": scores, "final_scores": final}


@dataclass(frozen=True)
class RunningCounts:
    """What CLEAR counts, under TrackEval's names."""

    CLR_TP: int = 0
    """Matches of labels and output boxes."""
    CLR_FP: int = 0
    """Output boxes without a label (false positives)."""
    CLR_FN: int = 0
    """Labels without an output box (misses)."""
    IDSW: int = 0
    """Identity switches."""

    def __add__(self, other: "RunningCounts") -> "RunningCounts":
        return RunningCounts(
            self.CLR_TP + other.CLR_TP,
            self.CLR_FP + other.CLR_FP,
            self.CLR_FN + other.CLR_FN,
            self.IDSW + other.IDSW,
        )

    @property
    def gain(self) -> int:
        """TP - FP - IDSW: MOTA is this over the number of labels."""
        return self.CLR_TP - self.CLR_FP - self.IDSW

    @property
    def MOTA(self) -> float:
        """1 - (FN + FP + IDSW) / labels; without labels as of one."""
        return self.gain / max(1, self.CLR_TP + self.CLR_FN)


@dataclass(eq=False)
class RunningClear:
    """TrackEval's CLEAR of KITTI's cars, counted one frame at a time.

    Matches of the frame before are kept where they can be; see `mot_sim.metrics`.
    """

    total: RunningCounts = field(default_factory=RunningCounts)
    """The counts so far."""
    names: dict[int, int] = field(default_factory=dict)
    """Output id with which each label was last matched, by label id."""
    before: frozenset[tuple[int, int]] = frozenset()
    """Matches (label id, output id) of the last frame that held labels and output."""

    def add(self, labels: Tracks, output: Tracks, frame: int) -> RunningCounts:
        """Count the rows of one frame. Raises BadTracks for rows that cannot be scored."""
        contest = prepare_sequence(labels, output, frame + 1)
        kept_labels, kept_output = ~contest.neutral, counted_output(contest)
        overlaps = contest.overlaps.keep(kept_labels, kept_output)
        ids = contest.overlaps.truth.ids[kept_labels].tolist()
        names = contest.overlaps.output.ids[kept_output].tolist()
        pairs = self._match(overlaps, ids, names, frame)
        if ids and names:
            self.before = frozenset(pairs)
        switches = sum(self.names.get(label, name) != name for label, name in pairs)
        self.names.update(pairs)
        found = len(pairs)
        counts = RunningCounts(found, len(names) - found, len(ids) - found, switches)
        self.total = self.total + counts
        return counts

    def _match(
        self, overlaps: Overlaps, ids: list[int], names: list[int], frame: int
    ) -> list[tuple[int, int]]:
        """The matched labels and names: first those that keep a name, then the most overlap."""
        near = np.flatnonzero(overlaps.iou >= MIN_OVERLAP - EPSILON)
        rows, columns = overlaps.rows[near].tolist(), overlaps.columns[near].tolist()
        pairs = [(ids[row], names[column]) for row, column in zip(rows, columns, strict=True)]
        if len(set(rows)) == len(rows) and len(set(columns)) == len(columns):
            return pairs
        kept = np.array([pair in self.before for pair in pairs])
        weights = CONTINUING_BONUS * kept + overlaps.iou[near]
        chosen = solve_frame(overlaps, frame, near, weights)
        return [pair for pair, is_chosen in zip(pairs, chosen.tolist(), strict=True) if is_chosen]


def counted_labels(labels: Tracks, frame_count: int) -> int:
    """How many boxes of the labels must be found."""
    return int((~prepare_sequence(labels, Tracks.empty(), frame_count).neutral).sum())

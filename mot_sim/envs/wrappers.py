"""Wrappers of scene environments: tracks in the observation, running scores in the info."""

from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium as gym
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs

from mot_sim.envs.counting import RunningClear
from mot_sim.envs.observing import Observation, observe_tracks, require_padding, track_space
from mot_sim.envs.runs import FrameTruth
from mot_sim.files.named_objects import make_tracker
from mot_sim.metrics import evaluate_sequence
from tracker import Camera, Frame, Tracker, Tracks
from tracker.errors import BadConfig

Step = tuple[Observation, Any, bool, bool, dict[str, Any]]
TRACKS = "tracks"


class TrackObservation(gym.Wrapper[Observation, Any, Observation, Any], RecordConstructorArgs):
    """Adds `tracks` (boxes, ids, mask) to the observation: what a tracker makes of the frames.

    tracker: a name (`module:name` too), or what builds a tracker for a camera. The rows of this
    moment are `env.tracks`.
    """

    def __init__(
        self,
        env: gym.Env[Observation, Any],
        tracker: str | Callable[[Camera], Tracker] = "default",
        max_tracks: int = 64,
    ) -> None:
        RecordConstructorArgs.__init__(self, tracker=tracker, max_tracks=max_tracks)
        super().__init__(env)
        require_padding("max_tracks", max_tracks)
        if isinstance(tracker, str):
            tracker = partial(make_tracker, tracker)
        self.max_tracks = max_tracks
        self.seen_by: Camera = env.get_wrapper_attr("camera")
        self.tracker = tracker(self.seen_by)
        self.tracks = Tracks.empty()
        space = env.observation_space
        if not isinstance(space, spaces.Dict):
            raise BadConfig(f"observations of {space} hold no tracks: wrap a scene environment")
        self.observation_space = spaces.Dict(
            {**space.spaces, TRACKS: track_space(self.seen_by, max_tracks)}
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The first frame of a new episode; the tracker has forgotten the last one."""
        observation, told = self.env.reset(seed=seed, options=options)
        self.tracker.reset()
        return self._track(observation), told

    def step(self, action: Any) -> Step:
        """The next frame, tracked."""
        observation, reward, terminated, truncated, told = self.env.step(action)
        return self._track(observation), reward, terminated, truncated, told

    def _track(self, observation: Observation) -> Observation:
        frame: Frame = self.env.get_wrapper_attr("frame")
        self.tracks = self.tracker.step(frame)
        seen = observe_tracks(self.tracks, self.seen_by, self.max_tracks)
        return {**observation, TRACKS: seen}


class Scored(gym.Wrapper[Observation, Any, Observation, Any], RecordConstructorArgs):
    """Adds to the info how good the tracks of a `TrackObservation` below are.

    `scores`: CLR_TP, CLR_FP, CLR_FN, IDSW and MOTA of the episode so far, counted frame by
    frame. `final_scores`: at the end of an episode all of `mot_sim.metrics` (HOTA, CLEAR,
    Identity) as a `ScoreNoise`; None before.
    """

    def __init__(self, env: gym.Env[Observation, Any]) -> None:
        RecordConstructorArgs.__init__(self)
        super().__init__(env)
        if not env.has_wrapper_attr(TRACKS):
            raise BadConfig("there are no tracks to score: wrap in TrackObservation before")
        self.clear = RunningClear()
        self.rows: list[tuple[Tracks, Tracks]] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The first frame of a new episode, counted from nothing."""
        observation, told = self.env.reset(seed=seed, options=options)
        self.clear, self.rows = RunningClear(), []
        return observation, self._score(told, False)

    def step(self, action: Any) -> Step:
        """The next frame, counted."""
        observation, reward, terminated, truncated, told = self.env.step(action)
        is_last = terminated or truncated
        return observation, reward, terminated, truncated, self._score(told, is_last)

    def _score(self, told: dict[str, Any], is_last: bool) -> dict[str, Any]:
        truth: FrameTruth = told["truth"]
        tracks: Tracks = self.env.get_wrapper_attr(TRACKS)
        self.rows.append((truth.labels, tracks))
        self.clear.add(truth.labels, tracks, len(self.rows) - 1)
        scores = {**vars(self.clear.total), "MOTA": self.clear.total.MOTA}
        final = None
        if is_last:
            labels, output = (Tracks.concatenate(part) for part in zip(*self.rows, strict=True))
            final = evaluate_sequence(labels, output, len(self.rows))
        return {**told, "scores": scores, "final_scores": final}

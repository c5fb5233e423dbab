"""Experts of the association environment, their data sets, and pools that do not meet."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium as gym
import numpy as np
from jaxtyping import Bool, Float, Int, Shaped
from numpy import ndarray as Array

from mot_sim.envs.observations import Observation
from tracker.association import Associate, Greedy, Hungarian
from tracker.errors import BadConfig, UnknownName

Policy = Callable[[Observation], Int[Array, " d"]]


def hungarian_policy(
    observation: Observation, max_cost: float = 1.0, birth_score: float = 0.0
) -> Int[Array, " d"]:
    """The action that matches at the least cost, and begins tracks with the other detections.

    max_cost: pairs that cost as much or more are never made. birth_score: detections from it on
    begin tracks; the others are rejected.
    """
    return _matched(observation, Hungarian(max_cost), birth_score)


def greedy_policy(
    observation: Observation, max_cost: float = 1.0, birth_score: float = 0.0
) -> Int[Array, " d"]:
    """The same, but the cheapest pair is matched first, then the cheapest of what is left."""
    return _matched(observation, Greedy(max_cost), birth_score)


EXPERTS: dict[str, Policy] = {"hungarian": hungarian_policy, "greedy": greedy_policy}


def find_expert(name: str) -> Policy:
    """An expert by its name. Raises UnknownName."""
    if name not in EXPERTS:
        raise UnknownName.of("expert", name, EXPERTS)
    return EXPERTS[name]


def _matched(observation: Observation, associate: Associate, birth_score: float) -> Array:
    """The action of a match of the observed costs."""
    slots, there = np.flatnonzero(observation["tracks"]), observation["detections"].astype(bool)
    table = np.ix_(slots, np.flatnonzero(there))
    costs = np.where(observation["possible"][table], observation["costs"][table], np.inf)
    pairs = associate(costs).pairs
    new, reject = len(observation["tracks"]), len(observation["tracks"]) + 1
    action = np.where(there & (observation["scores"] >= birth_score), new, reject)
    action[pairs[:, 1]] = slots[pairs[:, 0]]
    return action.astype(np.int64)


@dataclass(frozen=True, eq=False)
class ImitationDataset:
    """What an expert saw and did, one row per step, episode after episode."""

    observations: dict[str, Shaped[Array, "n *d"]]
    """What was seen before each action, by the keys of the observation."""
    actions: Int[Array, "n d"]
    """What the expert did."""
    masks: Bool[Array, "n c"]
    """The `action_masks()` of each step."""
    returns: Float[Array, " e"]
    """The return of each episode."""

    def __len__(self) -> int:
        return len(self.actions)


def imitation_dataset(
    env: gym.Env[Observation, Any], expert: str = "hungarian", episodes: int | None = None
) -> ImitationDataset:
    """All that an expert does in the first episodes of an association environment's pool.

    episodes: how many; None: the whole pool. Raises UnknownName for an expert that is not known,
    BadConfig for fewer than 1 episode and for more than the pool has.
    """
    find_expert(expert)
    act, masks_of = (env.get_wrapper_attr(name) for name in ("expert_action", "action_masks"))
    pool: int = env.get_wrapper_attr("pool")
    count = pool if episodes is None else episodes
    if not 1 <= count <= pool:
        raise BadConfig(f"{count} episodes for imitation: the pool has {pool}; give 1 to {pool}")
    seen: list[Observation] = []
    actions, masks, returns = [], [], np.zeros(count)
    for number in range(count):
        observation, _ = env.reset(options={"episode_number": number})
        ended = False
        while not ended:
            seen.append(observation)
            actions.append(act(expert))
            masks.append(masks_of())
            observation, reward, terminated, truncated, _ = env.step(actions[-1])
            returns[number] += float(reward)
            ended = terminated or truncated
    columns = {key: np.stack([one[key] for one in seen]) for key in seen[0]}
    return ImitationDataset(columns, np.stack(actions), np.stack(masks), returns)


def disjoint_pools(train: range, test: range) -> tuple[dict[str, int], dict[str, int]]:
    """Options of `gym.make` for episodes to train on and to test on, by their seeds.

    Raises BadConfig for a pool without episodes, for seeds that are not consecutive or negative,
    and for seeds that are in both.
    """
    for name, seeds in (("train", train), ("test", test)):
        if not len(seeds) or seeds.step != 1 or seeds.start < 0:
            raise BadConfig(f"{name} pool {seeds}: give consecutive seeds from 0 on, 1 or more")
    shared = range(max(train.start, test.start), min(train.stop, test.stop))
    if shared:
        raise BadConfig(
            f"train pool {train} and test pool {test} share seeds {shared.start} to "
            f"{shared.stop - 1}: what is tested would have been trained on"
        )
    options = [{"first_seed": seeds.start, "pool": len(seeds)} for seeds in (train, test)]
    return options[0], options[1]

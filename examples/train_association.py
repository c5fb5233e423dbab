"""Train who is who: clone the Hungarian policy, then improve it by MaskablePPO.

    pip install "mot-sim[rl]"
    python examples/train_association.py --out out/association

The network sees pairs of tracks and detections one by one with the same weights, so that what it
learns does not depend on the order of slots. PPO plays many episodes at once. All are tested on
seeds that they were not trained on.
"""

import argparse
from pathlib import Path
from time import process_time

import gymnasium as gym
import numpy as np
from scipy.stats import t as student

import mot_sim  # noqa: F401 - registers the ids
from mot_sim.envs.association_experts import (
    ImitationDataset,
    disjoint_pools,
    imitation_dataset,
)
from mot_sim.envs.association_vector_env import AssociationVectorEnv

try:
    import torch
    from sb3_contrib import MaskablePPO
    from sb3_contrib.common.maskable.policies import MaskableMultiInputActorCriticPolicy
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.policies import MultiInputActorCriticPolicy
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
    from stable_baselines3.common.vec_env import VecMonitor
    from torch import nn

    from mot_sim.envs.stable_baselines import StableBaselinesEpisodes
except ImportError as error:
    raise SystemExit(f"{error.name} is missing: pip install 'mot-sim[rl]'") from None

SIZE = {"max_detections": 12, "max_tracks": 12}
WIDTH = 32  # of the hidden layers
EPISODES_AT_ONCE, STEPS_OF_A_ROLLOUT = 32, 64  # of PPO
PAIR_INPUTS = 8  # features of a pair, ages of the track, score of the detection, whether possible


class PairLogits(BaseFeaturesExtractor):
    """The logits of all choices of all detections, and a summary for the value."""

    def __init__(self, observation_space: gym.spaces.Dict) -> None:
        tracks, detections = observation_space["costs"].shape
        self.choices = detections * (tracks + 2)
        super().__init__(observation_space, self.choices + WIDTH)
        self.pair = nn.Sequential(nn.Linear(PAIR_INPUTS, WIDTH), nn.Tanh(), nn.Linear(WIDTH, WIDTH))
        self.match = nn.Sequential(nn.Tanh(), nn.Linear(WIDTH, 1))
        self.alone = nn.Sequential(nn.Linear(WIDTH + 2, WIDTH), nn.Tanh(), nn.Linear(WIDTH, 2))

    def forward(self, seen: dict[str, torch.Tensor]) -> torch.Tensor:
        """(batch, choices + WIDTH)."""
        pairs, possible = seen["pairs"], seen["possible"][..., None]
        count, tracks, detections, _ = pairs.shape
        ages = seen["ages"][:, :, None].expand(count, tracks, detections, 2)
        scores = seen["scores"][:, None, :, None].expand(count, tracks, detections, 1)
        hidden = self.pair(torch.cat((pairs, ages, scores, possible), -1))
        best = (hidden * possible).amax(1)  # of every detection, over the tracks
        lonely = torch.cat(
            (best, seen["scores"][..., None], seen["possible"].amax(1)[..., None]), -1
        )
        match = self.match(hidden)[..., 0].transpose(1, 2)
        logits = torch.cat((match, self.alone(lonely)), -1)
        there = seen["detections"][..., None]
        summary = (best * there).sum(1) / there.sum(1).clamp(min=1.0)
        return torch.cat((logits.flatten(1), summary), 1)


class Halves(nn.Module):
    """The logits for the actor, the summary for the critic."""

    def __init__(self, choices: int) -> None:
        super().__init__()
        self.latent_dim_pi, self.latent_dim_vf = choices, WIDTH

    def forward(self, features: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Both."""
        return self.forward_actor(features), self.forward_critic(features)

    def forward_actor(self, features: torch.Tensor) -> torch.Tensor:
        """Logits."""
        return features[:, : self.latent_dim_pi]

    def forward_critic(self, features: torch.Tensor) -> torch.Tensor:
        """Summary."""
        return features[:, self.latent_dim_pi :]


class PairPolicy:
    """Mixin: the extractor's logits are those of the actions."""

    def _build_mlp_extractor(self) -> None:
        self.mlp_extractor = Halves(self.features_extractor.choices)

    def _build(self, lr_schedule: object) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Identity()
        self.optimizer = self.optimizer_class(
            self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs
        )


class PairPPOPolicy(PairPolicy, MultiInputActorCriticPolicy):
    """For PPO."""


class PairMaskablePolicy(PairPolicy, MaskableMultiInputActorCriticPolicy):
    """For MaskablePPO."""


class Curve(BaseCallback):
    """Prints the mean return of the last episodes after every second rollout."""

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        last = [episode["r"] for episode in self.model.ep_info_buffer]
        rollout = self.num_timesteps // (EPISODES_AT_ONCE * STEPS_OF_A_ROLLOUT)
        if last and rollout % 2 == 0:
            print(f"  {self.num_timesteps:7d} steps  {np.mean(last):.3f}", flush=True)


RECORDED: dict[int, object] = {}  # episodes of the training pool, recorded once for all learners


def agent(kind: type[PPO] | type[MaskablePPO], pool: dict[str, int], frames: int) -> PPO:
    """A new learner on the training pool."""
    plain = StableBaselinesEpisodes(EPISODES_AT_ONCE, frames=frames, **SIZE, **pool)
    plain.episodes.one.source.kept.update(RECORDED)
    env = VecMonitor(plain)
    policy = PairMaskablePolicy if kind is MaskablePPO else PairPPOPolicy
    options = {"features_extractor_class": PairLogits, "ortho_init": False}
    return kind(
        policy, env, n_steps=STEPS_OF_A_ROLLOUT, batch_size=256, n_epochs=4, gamma=0.9,
        gae_lambda=0.8, ent_coef=0.0, learning_rate=1e-3, clip_range=0.2, seed=0,
        policy_kwargs=options, device="cpu",
    )  # fmt: skip


def clone(model: PPO, shown: ImitationDataset, epochs: int = 30) -> None:
    """Behaviour cloning: the expert's choice is made likely for every detection that is there."""
    policy, rng = model.policy, np.random.default_rng(0)
    optimizer = torch.optim.Adam(policy.parameters(), lr=3e-3)
    seen = {key: torch.as_tensor(column).float() for key, column in shown.observations.items()}
    masks = torch.as_tensor(shown.masks).reshape(len(shown), SIZE["max_detections"], -1)
    actions, there = torch.as_tensor(shown.actions), seen["detections"]
    for epoch in range(epochs):
        losses = []
        for rows in np.array_split(rng.permutation(len(shown)), max(len(shown) // 16, 1)):
            features = policy.extract_features({key: part[rows] for key, part in seen.items()})
            logits = policy.mlp_extractor.forward_actor(features).reshape(masks[rows].shape)
            logits = logits.masked_fill(~masks[rows], -1e8).transpose(1, 2)
            each = nn.functional.cross_entropy(logits, actions[rows], reduction="none")
            # What the mask forbids (a new track without a free slot) is refused: nothing to learn.
            counted = there[rows] * (each < 1e6)
            loss = torch.where(counted > 0, each, 0.0).sum() / counted.sum().clamp(min=1.0)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            losses.append(float(loss.detach()))
        if epoch % 10 == 9:
            print(f"  epoch {epoch + 1:3d}  cross entropy {np.mean(losses):.4f}", flush=True)


def returns_of(act: object, envs: AssociationVectorEnv) -> np.ndarray:
    """The return of every episode of the pool, all played at once.

    act: actions (n, d) of the observations and the masks.
    """
    seen, _ = envs.reset(seed=0, options={"episode_number": np.arange(envs.num_envs)})
    found, over = np.zeros(envs.num_envs), np.zeros(envs.num_envs, bool)
    while not over.all():
        seen, rewards, ended, _, _ = envs.step(act(seen, envs.action_masks()))
        found += np.where(over, 0.0, rewards)
        over |= ended
    return found


def masked_draw(rng: np.random.Generator, masks: np.ndarray) -> np.ndarray:
    """One of the choices that the mask leaves, for every detection."""
    table = masks.reshape(len(masks), SIZE["max_detections"], -1)
    return (rng.random(table.shape) * table).argmax(axis=2)


def report(name: str, found: np.ndarray, best: np.ndarray) -> None:
    """A row of the table: mean and 95 % interval, and the share of the Hungarian policy's."""
    half = student.ppf(0.975, len(found) - 1) * found.std(ddof=1) / np.sqrt(len(found))
    print(
        f"| {name} | {found.mean():.3f} +- {half:.3f} | {found.mean() / best.mean():.3f} |",
        flush=True,
    )


LEARNERS = {"cloned": MaskablePPO, "PPO": PPO, "MaskablePPO": MaskablePPO, "improved": MaskablePPO}


def learn(name: str, folder: Path, train: dict[str, int], frames: int, steps: int) -> None:
    """Train one of LEARNERS and save it; `improved` begins with what `cloned` has learned."""
    started, model = process_time(), agent(LEARNERS[name], train, frames)
    print(f"{name}:", flush=True)
    if name == "cloned":
        clone(model, imitation_dataset(model.get_env().venv.episodes.one, "hungarian"))
    else:
        if name == "improved":
            known = MaskablePPO.load(folder / "cloned", device="cpu")
            model.policy.load_state_dict(known.policy.state_dict())
        model.learn(steps, callback=Curve())
    RECORDED.update(model.get_env().venv.episodes.one.source.kept)
    model.save(folder / name)
    print(f"  {process_time() - started:.0f} CPU seconds", flush=True)


def act_of(kind: type[PPO] | type[MaskablePPO], file: Path) -> object:
    """What a saved model does: its likeliest action."""
    model = kind.load(file, device="cpu")
    if kind is MaskablePPO:
        return lambda seen, masks: model.predict(seen, action_masks=masks, deterministic=True)[0]
    return lambda seen, masks: model.predict(seen, deterministic=True)[0]


def main() -> None:
    """Train what is not there yet, print the learning curves and the table, save the models."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/association"))
    parser.add_argument("--learners", nargs="*", default=list(LEARNERS), choices=list(LEARNERS))
    parser.add_argument("--frames", type=int, default=60, help="of an episode")
    parser.add_argument("--episodes", type=int, default=16, help="to train on, and to test on")
    parser.add_argument("--steps", type=int, default=8192, help="of each run of PPO")
    given = parser.parse_args()
    torch.set_num_threads(1)
    n, frames = given.episodes, given.frames
    train, test = disjoint_pools(range(n), range(1000, 1000 + n))
    given.out.mkdir(parents=True, exist_ok=True)
    for name in given.learners:
        if not (given.out / f"{name}.zip").exists():
            learn(name, given.out, train, frames, given.steps)
    envs = AssociationVectorEnv(n, frames=frames, **SIZE, **test)
    rng = np.random.default_rng(0)
    envs.action_space.seed(0)
    acts = {
        "random": lambda seen, masks: envs.action_space.sample(),
        "random within the masks": lambda seen, masks: masked_draw(rng, masks),
        "greedy": lambda seen, masks: envs.expert_actions("greedy"),
        "Hungarian": lambda seen, masks: envs.expert_actions("hungarian"),
    }
    acts |= {name: act_of(LEARNERS[name], given.out / name) for name in given.learners}
    best = returns_of(acts["Hungarian"], envs)
    print(f"\n| policy | return on {n} held-out seeds | of the Hungarian policy's |\n|---|---|---|")
    for name, act in acts.items():
        report(name, returns_of(act, envs), best)


if __name__ == "__main__":
    main()

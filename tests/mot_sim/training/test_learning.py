"""PCK, confidences, targets, the plan; a small training from crops to files, where torch is."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from mot_sim.simulation.truth import KeypointVisibility
from mot_sim.training.augmentation import AugmentedCrops, exact_crops
from mot_sim.training.keypoint_crops import FIRST_HELD_OUT_SEED, save_crops, shard_path
from mot_sim.training.keypoints import curve_picture, train_keypoints
from mot_sim.training.learning import (
    CHECKPOINT_FILE,
    KeypointTrainer,
    TrainingPlan,
    load_checkpoint,
    score_keypoints,
    train,
)
from mot_sim.training.network import target_maps
from mot_sim.training.warm_start import begin_with
from tests.mot_sim.cli.conftest import CommandLine, mot_sim
from tests.mot_sim.training.made_up import made_up
from tracker.errors import (
    BadConfig,
    BadFile,
    BadWeights,
    DatasetNotFound,
    OutputExists,
    UnknownName,
)
from tracker.shape import Hourglass, decode

__all__ = ["mot_sim"]  # the fixture

VISIBLE, HIDDEN = int(KeypointVisibility.VISIBLE), int(KeypointVisibility.SELF_OCCLUDED)


def test_a_keypoint_is_right_within_a_tenth_of_the_longer_side() -> None:
    true = np.zeros((1, 4, 2))
    found = np.array([[(0.0, 0.0, 1.0), (9.9, 0.0, 1.0), (8.0, 8.0, 1.0), (0.0, 0.0, 1.0)]])
    states = np.array([[VISIBLE, VISIBLE, VISIBLE, HIDDEN]], np.uint8)
    scores = score_keypoints(found, true, states, np.array([100.0]))
    assert scores.right.tolist() == [[True, True, False, False]]
    assert scores.pck == pytest.approx(2 / 3)


def test_confidences_that_are_the_truth_are_no_doubt() -> None:
    rng = np.random.default_rng(0)
    confidence = rng.uniform(size=(4000, 5))
    seen = rng.uniform(size=confidence.shape) < confidence
    found = np.dstack((np.zeros((4000, 5, 2)), confidence))
    states = np.where(seen, VISIBLE, HIDDEN).astype(np.uint8)
    scores = score_keypoints(found, np.zeros((4000, 5, 2)), states, np.ones(4000))
    assert scores.calibration_error < 0.02
    assert scores.reliability[:, 2].sum() == 20_000
    boasting = score_keypoints(
        found + (0.0, 0.0, 0.3), np.zeros((4000, 5, 2)), states, np.ones(4000)
    )
    assert boasting.calibration_error > 0.2


def test_nobody_is_judged_without_keypoints() -> None:
    states = np.zeros((0, 36), np.uint8)
    nothing = score_keypoints(np.zeros((0, 36, 3)), np.zeros((0, 36, 2)), states, np.zeros(0))
    assert np.isnan(nothing.pck)
    assert nothing.calibration_error == 0.0


def test_wanted_maps_decode_to_the_keypoints_they_were_made_from() -> None:
    shown = exact_crops(made_up(4))
    chances, seen = target_maps(shown, 16)
    assert chances.sum(axis=2) == pytest.approx(1.0)
    assert (chances[~seen][:, -1] == 1.0).all()
    odds = np.log(np.maximum(chances[:, :, :-1], 1e-12)) - np.log(
        np.maximum(chances[:, :, -1:], 1e-3)
    )
    found = decode(odds.reshape(4, 36, 16, 16).astype(np.float32))
    off = np.hypot(*(found[:, :, :2] - shown.keypoints)[seen].T)
    assert off.max() < 0.15 / 16  # of the crop: a seventh of a cell
    assert found[seen][:, 2].min() > 0.9
    assert found[~seen][:, 2].max() < 0.01


def test_a_keypoint_outside_the_crop_is_wanted_nowhere() -> None:
    shown = AugmentedCrops(
        np.zeros((1, 64, 64, 3), np.uint8), np.full((1, 36, 2), np.nan),
        np.full((1, 36), KeypointVisibility.TRUNCATED, np.uint8),
    )  # fmt: skip
    chances, seen = target_maps(shown, 16)
    assert not seen.any()
    assert (chances[0, :, -1] == 1.0).all()
    assert np.isfinite(chances).all()


@pytest.mark.parametrize(
    ("knobs", "told"),
    [
        ({"crops": 0}, "nothing to train with"),
        ({"epochs": 0}, "nothing to train with"),
        ({"crops": 10}, "do not fill a batch of 64"),
        ({"batch": 7}, "even number"),
        ({"rate": 2.0}, "rate 2"),
    ],
)
def test_a_plan_that_cannot_be_is_refused(knobs: dict[str, float], told: str) -> None:
    with pytest.raises(BadConfig) as caught:
        TrainingPlan(**knobs)  # type: ignore[arg-type]
    assert told in str(caught.value)


def test_a_size_that_nobody_knows_is_refused() -> None:
    with pytest.raises(UnknownName, match="shipped, small"):
        TrainingPlan(size="shiped")


def test_a_plan_counts_its_steps() -> None:
    plan = TrainingPlan(crops=100, epochs=3, batch=64)
    assert (plan.steps_per_epoch, plan.steps) == (3, 9)


def test_a_curve_is_drawn_a_panel_a_column() -> None:
    rows = [{"epoch": float(i), "loss": 2.0 / (i + 1), "pck": 0.1 * i} for i in range(4)]
    picture = curve_picture(rows)
    assert picture.shape[1] == 2 * curve_picture([{"epoch": 1.0, "loss": 1.0}]).shape[1]
    assert (picture != 255).any()


HAS_TORCH = find_spec("torch") is not None
needs_torch = pytest.mark.skipif(not HAS_TORCH, reason="PyTorch is not installed")
PLAN = TrainingPlan(crops=96, epochs=6, held_out=24, size="small", batch=32, average=20, rate=0.01)
STEPS = PLAN.steps


def say_nothing(what: str, done: int, total: int) -> None:
    """Nobody wants to know."""


def stop_at(step: int) -> Callable[[str, int, int], None]:
    """Ctrl-C when a training has come so far."""

    def tell(what: str, done: int, total: int) -> None:
        if total == STEPS and done >= step:
            raise KeyboardInterrupt

    return tell


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """A folder with crops in it, so that none need be drawn."""
    save_crops(made_up(PLAN.crops, 0), shard_path(tmp_path / "crops", 0))
    save_crops(made_up(PLAN.held_out, 1), shard_path(tmp_path / "crops", FIRST_HELD_OUT_SEED))
    return tmp_path


@pytest.mark.skipif(HAS_TORCH, reason="PyTorch is installed")
def test_without_pytorch_the_command_says_what_to_install(
    mot_sim: CommandLine, tmp_path: Path
) -> None:
    outcome = mot_sim("train-keypoints", "--out", tmp_path / "new")
    assert outcome.code == 2
    assert "pip install 'mot-sim[train]'" in outcome.err
    assert outcome.err.count("\n") == 1
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("options", "told"),
    [(("--crops", "0"), "nothing to train with"), (("--size", "huge"), "shipped, small")],
)
def test_a_wrong_option_is_one_line(
    mot_sim: CommandLine, tmp_path: Path, options: tuple[str, ...], told: str
) -> None:
    outcome = mot_sim("train-keypoints", "--out", tmp_path / "new", *options)
    assert outcome.code == 2
    assert told in outcome.err


@needs_torch
@pytest.mark.slow
def test_a_training_learns_and_the_tracker_loads_it(out: Path) -> None:
    scores = train_keypoints(PLAN, out, say_nothing)
    assert scores.right.shape == (PLAN.held_out, 36)
    curve = np.loadtxt(out / "curve.csv", delimiter=",", skiprows=1)
    assert len(curve) == PLAN.epochs
    assert curve[-1, 1] < 0.75 * curve[0, 1]
    assert scores.pck > 0.5
    assert (out / "curve.png").stat().st_size > 1000
    hourglass = Hourglass.load(out / "hourglass.onnx")
    assert hourglass.card["training"] == PLAN.as_dict()
    assert json.loads((out / "hourglass.json").read_text())["pck_synthetic"] >= 0.0
    seen = hourglass(made_up(1).images[0], np.array([[10.0, 20.0, 80.0, 70.0]]))
    assert np.isfinite(seen.keypoints).all()


@needs_torch
@pytest.mark.slow
def test_opencv_and_pytorch_see_the_same(out: Path) -> None:
    import torch

    from mot_sim.training.keypoints import export_network
    from tracker.shape import network_input

    trainer = KeypointTrainer.begin(PLAN)
    for _ in range(3):
        trainer.learn(made_up(PLAN.crops))
    path = export_network(trainer.mean, out / "three.onnx", {"training": PLAN.as_dict()})
    crops = made_up(5).images[:, :64, :64]
    trainer.mean.eval()
    with torch.no_grad():
        every, activations = trainer.mean(torch.from_numpy(network_input(crops)))
    found = Hourglass.load(path).run(crops)
    assert found[0] == pytest.approx(every[-1].numpy(), abs=2e-3)
    assert found[1] == pytest.approx(activations.numpy(), abs=2e-3)


@needs_torch
@pytest.mark.slow
def test_a_training_goes_on_from_the_weights_of_a_file(out: Path, tmp_path: Path) -> None:
    import torch

    from tracker.shape import network_input

    first = train_keypoints(PLAN, out, say_nothing)
    start, crops = out / "hourglass.onnx", made_up(PLAN.crops)
    trainer, shown = KeypointTrainer.begin(PLAN), made_up(5).images[:, :64, :64]
    begin_with(trainer.network, start, crops, 0)
    trainer.network.eval()
    with torch.no_grad():
        every, _ = trainer.network(torch.from_numpy(network_input(shown)))
    assert every[-1].numpy() == pytest.approx(Hourglass.load(start).run(shown)[0], abs=2e-3)
    later = tmp_path / "later"
    shutil.copytree(out / "crops", later / "crops")
    scores = train_keypoints(replace(PLAN, epochs=1, rate=1e-4), later, say_nothing, start=start)
    assert scores.pck > first.pck - 0.1
    card = Hourglass.load(later / "hourglass.onnx").card
    assert card["training"]["start"] == Hourglass.load(start).sha256
    with pytest.raises(BadWeights, match="--size"):
        begin_with(KeypointTrainer.begin(replace(PLAN, size="shipped")).network, start, crops, 0)


@needs_torch
@pytest.mark.slow
def test_an_interrupted_training_goes_on_as_if_nothing_had_been(out: Path, tmp_path: Path) -> None:
    crops, held_out = made_up(PLAN.crops), made_up(PLAN.held_out, 1)
    whole = train(PLAN, crops, held_out, tmp_path / "whole", say_nothing)
    with pytest.raises(KeyboardInterrupt):
        train(PLAN, crops, held_out, out, stop_at(STEPS // 2))
    resumed = train(PLAN, crops, held_out, out, say_nothing, resume=True)
    assert resumed.step == whole.step == STEPS
    assert len(resumed.curve) == len(whole.curve) == PLAN.epochs
    assert resumed.curve[-1]["loss"] == pytest.approx(whole.curve[-1]["loss"], abs=1e-6)
    for name, value in whole.mean.state_dict().items():
        assert np.allclose(value.numpy(), resumed.mean.state_dict()[name].numpy(), atol=1e-6), name


@needs_torch
@pytest.mark.slow
def test_what_cannot_go_on_says_so_and_loses_nothing(out: Path) -> None:
    with pytest.raises(DatasetNotFound, match="no checkpoint"):
        train_keypoints(PLAN, out, say_nothing, resume=True)
    with pytest.raises(KeyboardInterrupt):
        train_keypoints(PLAN, out, stop_at(2))
    kept = (out / CHECKPOINT_FILE).read_bytes()
    with pytest.raises(OutputExists, match="--resume"):
        train_keypoints(PLAN, out, say_nothing)
    with pytest.raises(BadConfig, match="epochs 6, now 7"):
        train_keypoints(replace(PLAN, epochs=7), out, say_nothing, resume=True)
    assert (out / CHECKPOINT_FILE).read_bytes() == kept
    (out / CHECKPOINT_FILE).write_bytes(kept[: len(kept) // 2])
    with pytest.raises(BadFile, match="no checkpoint"):
        train_keypoints(PLAN, out, say_nothing, resume=True)
    assert (out / CHECKPOINT_FILE).read_bytes() == kept[: len(kept) // 2]


@needs_torch
def test_a_checkpoint_of_an_older_format_is_refused(out: Path) -> None:
    import torch

    path = out / CHECKPOINT_FILE
    path.parent.mkdir(parents=True, exist_ok=True)
    torch.save({"format": 1, "lately": [0.5]}, path)
    with pytest.raises(BadConfig, match="of format 1, not 2: take another --out"):
        load_checkpoint(KeypointTrainer.begin(PLAN), path)

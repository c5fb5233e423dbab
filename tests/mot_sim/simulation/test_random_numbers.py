"""Random numbers by counter: keyed, uniform, independent, the same everywhere."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest

from mot_sim.simulation import random_numbers

COUNT = 20_000
GOLDEN_BITS = [
    ["0x4b2417cb704b0790", "0xe6c77380a5372df0"],
    ["0x61efdac37d3e871c", "0xee2cd1bdb66944e5"],
    ["0xaea3adf94d230c24", "0x47a5685a1fa1e0cb"],
]
keys = st.lists(
    st.tuples(st.integers(-5, 2**62), st.integers(0, 2**40)), min_size=1, max_size=20, unique=True
)


def row(value: int) -> np.ndarray:
    return np.full(COUNT, value)


def test_bits_are_the_same_on_every_machine() -> None:
    bits = random_numbers.bits(0, "jitter", np.array([0, 1, -1]), np.array([0, 7, 7]), 2)
    assert [[hex(value) for value in two] for two in bits.tolist()] == GOLDEN_BITS


@given(keys, st.randoms(use_true_random=False))
def test_a_draw_depends_on_its_key_alone(rows, random) -> None:
    ids, frames = np.array(rows, dtype=np.int64).T
    drawn = random_numbers.bits(3, "miss", ids, frames, 2)
    order = list(range(len(rows)))
    random.shuffle(order)
    some = np.array(order[: 1 + len(order) // 2])
    assert (random_numbers.bits(3, "miss", ids[some], frames[some], 2) == drawn[some]).all()
    assert (random_numbers.bits(3, "miss", ids, frames, 1)[:, 0] == drawn[:, 0]).all()


@pytest.mark.parametrize(
    "changed", [(1, "a", 0, 0), (0, "b", 0, 0), (0, "a", 1, 0), (0, "a", 0, 1)]
)
def test_any_other_key_gives_other_bits(changed) -> None:
    seed, effect, track_id, frame = changed
    other = random_numbers.bits(seed, effect, np.array([track_id]), np.array([frame]), 4)
    assert not (other == random_numbers.bits(0, "a", np.array([0]), np.array([0]), 4)).any()


@pytest.mark.parametrize("ids_run", [True, False])
def test_numbers_over_ids_and_over_frames_are_uniform_and_normal(ids_run) -> None:
    run, fixed = np.arange(COUNT), row(5)
    ids, frames = (run, fixed) if ids_run else (fixed, run)
    uniform = random_numbers.uniform(1, "score", ids, frames)[:, 0]
    assert 0.0 < uniform.min() < uniform.max() < 1.0
    assert kstest(uniform, "uniform").pvalue > 1e-3
    assert kstest(random_numbers.normal(1, "score", ids, frames)[:, 0], "norm").pvalue > 1e-3


def test_neighbouring_keys_are_uncorrelated() -> None:
    run = np.arange(COUNT)
    here = random_numbers.normal(0, "a", run, row(0), 2)
    others = {
        "next id": random_numbers.normal(0, "a", run + 1, row(0)),
        "next frame": random_numbers.normal(0, "a", run, row(1)),
        "next seed": random_numbers.normal(1, "a", run, row(0)),
        "other effect": random_numbers.normal(0, "b", run, row(0)),
        "next column": here[:, 1:],
        "id and frame swapped": random_numbers.normal(0, "a", row(0), run),
    }
    for name, other in others.items():
        correlation = np.corrcoef(here[1:, 0], other[1:, 0])[0, 1]
        assert abs(correlation) < 4.0 / np.sqrt(COUNT), name


def test_the_extreme_bits_stay_inside_the_open_interval(monkeypatch) -> None:
    ends = np.array([[0], [2**64 - 1]], dtype=np.uint64)
    monkeypatch.setattr(random_numbers, "bits", lambda *key: ends)
    uniform = random_numbers.uniform(0, "", np.zeros(2, np.int64), np.zeros(2, np.int64))
    assert 0.0 < uniform[0, 0] < uniform[1, 0] < 1.0


def test_any_integer_is_a_seed() -> None:
    one = np.array([1])
    seeds = (-1, 0, 2**64, 2**200)
    assert len({int(random_numbers.bits(seed, "a", one, one)[0, 0]) for seed in seeds}) == 4


def test_nobody_draws_nothing() -> None:
    nobody = np.zeros(0, np.int64)
    assert random_numbers.normal(0, "a", nobody, nobody, 3).shape == (0, 3)


def test_named_streams_repeat_and_differ() -> None:
    first = random_numbers.named_stream(4, "traffic").random(5)
    assert (random_numbers.named_stream(4, "traffic").random(5) == first).all()
    assert not (random_numbers.named_stream(4, "odometry").random(5) == first).any()
    assert not (random_numbers.named_stream(5, "traffic").random(5) == first).any()

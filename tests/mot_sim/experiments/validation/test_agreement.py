"""Differences, ranks and leads, by scores that were made for it."""

from dataclasses import replace

import numpy as np
import pytest

from mot_sim.experiments.validation import METRICS, Agreement
from mot_sim.experiments.validation.agreement import MIN_BOOTSTRAP_DRIVES, correlation
from mot_sim.experiments.validation.agreement_tables import (
    agreement_content,
    agreement_table,
    lead_table,
    scenes_table,
    scores_table,
)
from mot_sim.experiments.validation.sums import addends, score_of_sums
from mot_sim.metrics import Clear, Hota, Identity, Scores
from mot_sim.metrics.evaluation import combine
from tracker.errors import UnknownName

NAMES = ("default", "iou", "sort")


def scores(misses: int, switches: int) -> Scores:
    """Of a drive with 1000 labels."""
    ones, found = np.ones(19, np.int64), 1000 - misses
    share = np.full(19, found / 1000)
    clear = Clear(
        CLR_TP=found, CLR_FN=misses, CLR_FP=0, IDSW=switches, MT=1, PT=0, ML=0, Frag=0,
        MOTP_sum=0.9 * found, CLR_Frames=100,
    )  # fmt: skip
    hota = Hota(found * ones, misses * ones, 0 * ones, share, share, share, share)
    return Scores(clear, hota, Identity(found, misses, 0))


def agreement(shift: int = 0, drives: int = 6) -> Agreement:
    """Three trackers; made drives have `shift` misses more in each, and as many switches."""
    misses = {"default": 50, "iou": 90, "sort": 70}
    real = {
        name: [scores(each + 5 * drive, each // 10) for drive in range(drives)]
        for name, each in misses.items()
    }
    made = {
        name: {
            f"seed {seed}": [
                scores(each + 5 * drive + shift, each // 10) for drive in range(drives)
            ]
            for seed in range(2)
        }
        for name, each in misses.items()
    }
    return Agreement(NAMES, frozenset({"sort"}), real, made)


def test_the_same_scores_agree_in_everything() -> None:
    found = agreement()
    for metric in METRICS:
        assert found.within(metric).sum() == 3
        assert found.rank_interval(metric).cells == (1.0, 1.0, 1.0)
        assert found.rank_correlation(metric, "kendall") == 1.0
        assert found.ceiling(metric) == 1.0
        real, made = found.leads(metric)
        assert real == made
        assert (real.leader, real.guest) == ("default", "sort")
        assert real.points > 0.0


@pytest.mark.parametrize(("shift", "near", "far"), [(9, 3, 3), (14, 0, 3), (16, 0, 0)])
def test_rows_are_near_and_far(shift: int, near: int, far: int) -> None:
    found = agreement(shift)
    assert found.differences("MOTA")[0].mean == pytest.approx(-shift / 1000)
    assert found.within("MOTA").sum() == near
    assert found.within("MOTA", far=True).sum() == far


def test_few_switches_more_are_near() -> None:
    found = agreement()
    more = {
        name: {world: [scores(50, 3)] * 6 for world in worlds}
        for name, worlds in found.made.items()
    }
    moved = replace(found, made=more)  # 18 where 30, 54 and 42 are real
    assert moved.within("IDSW").tolist() == [0.0, 0.0, 0.0]
    few = {
        name: {world: [scores(50, 5 - (place == 0))] * 6 for place, world in enumerate(worlds)}
        for name, worlds in found.made.items()
    }
    assert replace(found, made=few).within("IDSW").tolist() == [1.0, 0.0, 0.0]


def test_a_lead_that_is_overstated() -> None:
    found = agreement()
    worse = dict(found.made) | {
        "sort": {world: [scores(170, 7)] * 6 for world in found.worlds},
    }
    real, made = replace(found, made=worse).leads("MOTA")
    assert made.points - real.points == pytest.approx(0.0875)
    table = lead_table(replace(found, made=worse))
    assert table is not None
    assert table.column("overstated by")[0] == pytest.approx(8.75)


def test_too_few_drives_have_no_interval_and_no_ceiling() -> None:
    found = agreement(drives=MIN_BOOTSTRAP_DRIVES - 1)
    assert found.rank_interval("MOTA").cells == (1.0, None, None)
    assert found.ceiling("MOTA") is None
    assert "too few" in agreement_table(found).note


def test_without_guests_nobody_leads_them() -> None:
    found = replace(agreement(), guests=frozenset())
    assert found.leads("HOTA") is None
    assert lead_table(found) is None


def test_ranks_of_alike_scores_are_unknown() -> None:
    assert np.isnan(correlation(np.ones(3), np.arange(3.0)))


def test_tables_and_plain_numbers_say_the_same() -> None:
    found = agreement(14)
    table, content = scores_table(found, "here"), agreement_content(found)
    assert table.column("tracker") == NAMES
    assert table.column("MOTA made - real")[1] == pytest.approx(-0.014)
    assert content["trackers"]["iou"]["MOTA"]["real"] == table.column("MOTA")[1]
    assert content["metrics"]["MOTA"]["near"] == 0
    assert agreement_table(found).column("rows within")[0] == 0
    assert scenes_table({"street": found}).column("scene") == ("street",)


def test_sums_give_what_combining_gives() -> None:
    parts = [scores(50, 3), scores(120, 9), scores(0, 1)]
    whole, sums = combine(parts), addends(parts).sum(axis=0)[None]
    for metric in METRICS:
        assert score_of_sums(sums, metric)[0] == pytest.approx(whole[metric], abs=1e-12)
    with pytest.raises(UnknownName, match="Did you mean 'MOTA'"):
        score_of_sums(sums, "MOTP")

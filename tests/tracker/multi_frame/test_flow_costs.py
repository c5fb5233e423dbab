"""What the four numbers of a flow mean."""

import numpy as np
import pytest

from tracker.errors import BadConfig
from tracker.multi_frame import FlowCosts
from tracker.multi_frame.flow_costs import MAX_SCORE_NATS


def test_scores_count_by_their_log_odds_up_to_a_limit() -> None:
    costs = FlowCosts().of_scores(np.array([0.0, 0.25, 0.5, 0.75, 1.0]))
    np.testing.assert_allclose(
        costs, [MAX_SCORE_NATS, np.log(3.0), 0.0, -np.log(3.0), -MAX_SCORE_NATS]
    )


def test_a_link_at_the_largest_cost_is_as_dear_as_a_birth_and_a_perfect_one_gains() -> None:
    costs = FlowCosts(birth=10.0, fit=2.0)
    links = costs.of_links(np.array([0.0, 0.35, 0.7]), 0.7, np.zeros(3))
    np.testing.assert_allclose(links, [-2.0, 12.0 / 4.0 - 2.0, 10.0])


def test_a_gap_costs_once_and_by_the_second() -> None:
    costs = FlowCosts(fit=0.0, gap=2.0, missed=3.0)
    links = costs.of_links(np.zeros(3), 0.7, np.array([0.0, 0.1, 1.0]))
    np.testing.assert_allclose(links, [0.0, 2.3, 5.0])


@pytest.mark.parametrize(
    "bad", [{"birth": 0.0}, {"fit": -1.0}, {"gap": np.nan}, {"missed": np.inf}]
)
def test_numbers_that_cannot_be_are_refused(bad: dict[str, float]) -> None:
    with pytest.raises(BadConfig, match="finite numbers"):
        FlowCosts(**bad)

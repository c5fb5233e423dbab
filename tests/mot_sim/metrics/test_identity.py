"""Identity scores: one name for one car over the whole sequence."""

import pytest

from benchmarks.metrics.cases import tracks
from mot_sim.metrics import Identity, evaluate_sequence

BOX = (0.0, 0.0, 40.0, 30.0)
FAR = (500.0, 0.0, 540.0, 40.0)
PARKED = [(frame, 1, BOX) for frame in range(4)]


def identity(labels: list[tuple], output: list[tuple]) -> Identity:
    """Identity scores by TrackEval's rules over ten frames."""
    scores = evaluate_sequence(tracks(labels), tracks(output), 10).identity
    assert scores is not None
    return scores


def test_a_name_changed_halfway_is_right_half_the_time():
    scores = identity(PARKED, [(0, 5, BOX), (1, 5, BOX), (2, 6, BOX), (3, 6, BOX)])
    assert (scores.IDTP, scores.IDFN, scores.IDFP) == (2, 2, 2)
    assert (scores.IDF1, scores.IDR, scores.IDP) == (0.5, 0.5, 0.5)


def test_one_name_cannot_serve_two_cars():
    labels = [(0, 1, BOX), (1, 2, BOX), (2, 2, BOX)]
    scores = identity(labels, [(frame, 5, BOX) for frame in range(3)])
    assert (scores.IDTP, scores.IDFN, scores.IDFP) == (2, 1, 1)


def test_all_names_together_fit_best_even_if_none_gets_its_favourite():
    # Name 5 shares 3 frames with car 1 and 2 with car 2; name 6 shares 2 with car 1 only.
    labels = [(frame, 1, BOX) for frame in range(5)] + [(frame, 2, FAR) for frame in (5, 6)]
    output = [(frame, 5, BOX) for frame in range(3)] + [(frame, 5, FAR) for frame in (5, 6)]
    scores = identity(labels, output + [(frame, 6, BOX) for frame in (3, 4)])
    assert scores.IDTP == 4


@pytest.mark.parametrize(("labels", "output"), [([], []), (PARKED, []), ([], PARKED)])
def test_one_side_alone_has_no_identity(labels: list, output: list):
    scores = identity(labels, output)
    assert scores.IDTP == 0
    counts = scores.IDFN, scores.IDFP
    assert counts == (len(labels), len(output))
    assert (scores.IDF1, scores.IDR, scores.IDP) == (0.0, 0.0, 0.0)


def test_counts_add_up_when_combined():
    both = Identity.combine([Identity(3, 1, 0), Identity(0, 0, 4)])
    assert (both.IDTP, both.IDFN, both.IDFP) == (3, 1, 4)
    assert both.IDF1 == 3 / 5.5

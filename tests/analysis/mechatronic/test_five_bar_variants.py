"""The five-bar's printed numbers against what is not printed."""

import pytest

from gapscope.analysis.mechatronic import five_bar_variants
from gapscope.analysis.mechatronic.five_bar_variants import CIRCLES, PRINTED
from gapscope.diagrams.five_bar_loop import GAINS, MOTIONS, FiveBarLoop


@pytest.fixture(scope="module")
def variants():
    return {v.name: v for v in five_bar_variants.variants()}


def test_assumed_feedforward_is_that_of_the_printed_x_move():
    share = five_bar_variants.feedforward_as_printed(MOTIONS["x-move"], GAINS["x-move"])
    assert FiveBarLoop().feedforward == pytest.approx(share, abs=0.01)


def test_feedforward_of_the_x_move_has_both_printed_circles(variants):
    """Fitted on the move alone; 0.25 ("about") and 0.3 ("approximately") printed, read to 0.05 there."""
    found = variants["as assumed"]
    assert found.off_path == pytest.approx(PRINTED, abs=0.1)
    assert found.circle == pytest.approx(CIRCLES["circle"].error, abs=0.035)
    assert found.fast_circle == pytest.approx(CIRCLES["fast-circle"].error, abs=0.035)


def test_without_feedforward_no_height_has_the_printed_x_move(variants):
    assert variants["no feed-forward"].off_path == pytest.approx(26.1, abs=0.1)
    assert variants["no feed-forward, X move at y = 1.05 m"].off_path > PRINTED + 1.0


def test_circles_at_full_feed_exclude_their_printed_errors(variants):
    """Bound over all centres; with 5 m/s^2 along the circle the fast error is about twice the slow one, not 1.2 times."""
    for name, printed in CIRCLES.items():
        assert five_bar_variants.least_error(MOTIONS[name], GAINS[name]) > printed.error + 0.05
    abrupt = variants["5 m/s^2 along the circles"]
    assert abrupt.fast_circle > 1.7 * abrupt.circle
    none = variants["no feed-forward"]
    assert none.circle > five_bar_variants.least_error(MOTIONS["circle"], GAINS["circle"])


def test_printed_lags_exclude_the_printed_errors():
    for name, printed in CIRCLES.items():
        assert printed.lag * five_bar_variants.peak_rate(MOTIONS[name]) > 2.0 * printed.error

"""The X move's deviation against what is not printed."""

import pytest

from gapscope.analysis.mechatronic import x_move
from gapscope.analysis.mechatronic.five_bar_study import CIRCLES
from gapscope.diagrams.five_bar_loop import GAINS, HEIGHT, MOTIONS

PATH, GAIN = MOTIONS["x-move"], GAINS["x-move"]


def test_lag_of_the_position_loop_explains_the_diagram_s_deviation():
    """26.08 mm by the diagram, ``gapscope compare 5r``."""
    assert x_move.deviation(PATH, GAIN, 0.0) == pytest.approx(26.08, abs=0.1)


def test_no_height_gives_the_printed_deviation_but_a_share_of_feedforward_does():
    off = x_move.by_height(PATH, GAIN)
    assert min(off.values()) > x_move.PRINTED + 1.0
    assert off[HEIGHT] == pytest.approx(x_move.deviation(PATH, GAIN, 0.0))
    share = x_move.feedforward_as_printed(PATH, GAIN)
    assert x_move.deviation(PATH, GAIN, share) == pytest.approx(x_move.PRINTED, abs=0.05)
    assert 0.3 < share < 0.5


def test_circles_ask_for_other_shares_of_feedforward():
    """0.4035 and 0.7727 motor turns by the diagram; 0.25 and 0.3 printed. One share does not give both."""
    shares = []
    for name, diagram in (("circle", 0.4035), ("fast-circle", 0.7727)):
        path, printed = MOTIONS[name], CIRCLES[name]
        assert x_move.joint_error(path, GAINS[name], 0.0) == pytest.approx(diagram, abs=0.02)
        shares.append(x_move.circle_feedforward(path, GAINS[name], printed.error))
        assert printed.lag * x_move.peak_rate(path) > 2.0 * printed.error
    assert shares[1] > shares[0] + 0.1

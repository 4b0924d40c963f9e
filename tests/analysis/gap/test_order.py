"""Shares of several effects: sum to one, and do not depend on the order they were found in."""

import pytest

from gapscope.analysis.gap.order import shapley


def losses(**values):
    return {frozenset(key.replace("o", "")): value for key, value in values.items()}


def test_effects_that_add_up_get_what_they_remove():
    found = shapley(("a", "b"), losses(o=10.0, a=7.0, b=5.0, ab=2.0))
    assert [s.share for s in found] == pytest.approx([3.0 / 8.0, 5.0 / 8.0])
    assert all(s.first == pytest.approx(s.last) for s in found)


def test_effects_that_stand_in_for_each_other_share_what_either_removes():
    found = shapley(("a", "b"), losses(o=10.0, a=2.0, b=2.0, ab=2.0))
    assert [s.share for s in found] == pytest.approx([0.5, 0.5])
    assert [s.first for s in found] == pytest.approx([1.0, 1.0])
    assert [s.last for s in found] == pytest.approx([0.0, 0.0])


def test_three_effects_share_out_the_whole():
    table = losses(o=9.0, a=8.0, b=6.0, c=7.0, ab=4.0, ac=5.0, bc=4.5, abc=1.0)
    found = shapley(("a", "b", "c"), table)
    assert sum(s.share for s in found) == pytest.approx(1.0)
    # By hand: mean over the six orders of what a takes off, over 8.
    orders = [1.0, 1.0, 2.0, 2.0, 3.5, 3.5]
    assert found[0].share == pytest.approx(sum(orders) / 6.0 / 8.0)


def test_nothing_removed_has_no_shares():
    assert shapley(("a", "b"), losses(o=1.0, a=1.0, b=1.0, ab=1.0)) == []

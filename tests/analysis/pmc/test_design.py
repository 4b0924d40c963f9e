"""Other dimensions of the PepperMill-Carrier."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.analysis.pmc import design, design_plot
from gapscope.models.pmc.parameters import PMCParameters

PROTOTYPE = PMCParameters()


def test_merit_follows_the_screws_and_the_spacing():
    """Torque is proportional to the lead; the spacing only changes the height."""
    g = PROTOTYPE.geometry
    base = design.merit(g, PROTOTYPE)
    coarse = design.merit(replace(g, lead=2.0 * g.lead), PROTOTYPE)
    low = design.merit(replace(g, spacing=g.spacing - 0.05), PROTOTYPE)
    assert coarse.torque == pytest.approx(2.0 * base.torque)
    assert coarse.volume > base.volume
    assert low.height == pytest.approx(base.height - 0.1)
    assert (low.torque, low.volume) == pytest.approx((base.torque, base.volume))


def test_merit_of_the_prototype():
    """The motors give the gripper less than a tenth of a newton metre somewhere in the workspace."""
    merit = design.merit(PROTOTYPE.geometry, PROTOTYPE)
    assert 0.0 < merit.torque < 0.1
    assert merit.cycle_room > 0.3


@pytest.mark.slow
def test_front_keeps_the_limits_and_beats_the_prototype():
    result = design.optimise(PROTOTYPE, generations=20)
    for front in (result.front, result.same_lead):
        volumes = [m.volume for _, m in front]
        torques = [m.torque for _, m in front]
        assert len(front) >= 3
        assert volumes == sorted(volumes, reverse=True)
        assert torques == sorted(torques)
        for _, merit in front:
            assert merit.height < 1.001 * result.prototype.height
            assert merit.cycle_room > -1e-4
        # The prototype does not dominate any point of the front.
        assert not any(
            m.volume < result.prototype.volume and m.torque < result.prototype.torque
            for _, m in front
        )
    assert {g.lead for g, _ in result.same_lead} == {PROTOTYPE.geometry.lead}
    assert np.isfinite(len(design_plot.png(result)))

"""A form takes the place of own parameters only as far as the parameters that stand for them are kept."""

from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine


def test_an_inertia_whose_payload_was_dropped_may_move_again(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    (payload,) = (f for f in machine.forms(runs) if f.effect == "inertia.payload")

    def own(hypothesis):
        return {p.name for effect, p in hypothesis.free(machine) if effect == ""}

    inertias = {"inertia_translation", "inertia_rotation"}
    assert inertias <= own(Hypothesis())
    both = Hypothesis(forms=(payload,))
    assert not inertias & own(both)
    mass_alone = both.drop(("inertia.payload", "extra_collar_inertia"))
    assert inertias & own(mass_alone) == {"inertia_rotation"}

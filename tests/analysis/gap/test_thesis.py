"""The thesis's own gap: planted truths, bounds of linear drives, and the check on the held-out table."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.machines.c_drive import c_drive_machine
from gapscope.analysis.gap.thesis import diagnosis
from gapscope.analysis.gap.thesis.candidates import candidate_forms
from gapscope.analysis.gap.thesis.carry_over import carry_over
from gapscope.analysis.gap.thesis.evidence import observations
from gapscope.analysis.gap.thesis.experiment import (
    METRICS,
    TESTS,
    quantisation,
    read_experiment,
    repeatability,
    scatter,
)
from gapscope.analysis.gap.thesis.fitting import FOLDS, TableFitter
from gapscope.analysis.gap.thesis.loops import BenchmarkLoops
from gapscope.models.c_drive import CDriveParameters

MACHINE = c_drive_machine(CDriveParameters(), 0.03)
WELL_FITTED = 0.2 * scatter(read_experiment(2.0)).relative  # a search stops well inside the scatter


@pytest.fixture(scope="module")
def loops():
    return {rate: BenchmarkLoops(rate) for rate in (2.0, 1.0)}


def form(effect, name=""):
    return next(
        f
        for f in candidate_forms(MACHINE, read_experiment(2.0))
        if f.effect == effect and name in f.name
    )


def planted(loops, rate, effect, values, name=""):
    """A table measured on a machine with this effect and no scatter."""
    hypothesis = Hypothesis(forms=(form(effect, name),))
    plant = hypothesis.plant(MACHINE, {(effect, key): v for key, v in values.items()})
    return replace(read_experiment(rate), measured=loops[rate].metrics([plant])[0])


def fitter(loops, experiment):
    return TableFitter(MACHINE, loops[experiment.rate], experiment, scatter(read_experiment(2.0)))


def test_scatter_is_what_one_law_run_twice_differs_by():
    # Table 5-4, translation, PD and TS: 1.4354 and 1.3148 N m, 0.3057 and 0.2751 mm.
    logs = np.log([1.4354 / 1.3148, 0.3057 / 0.2751])
    assert repeatability(read_experiment(2.0)) == pytest.approx(np.sqrt(np.sum(logs**2) / 4.0))
    found = scatter(read_experiment(2.0))
    assert found.additive[1:].tolist() == [0.0043, 0.0009]


def test_scatter_alone_gives_the_relative_error_it_is_named_after():
    table = read_experiment(2.0)
    found = scatter(table)
    rng = np.random.default_rng(3)
    n = 400
    spread = np.hypot(found.relative * table.measured, found.additive)
    drawn = table.measured + spread * rng.standard_normal((n, *table.measured.shape))
    rms = np.sqrt(np.mean(found.relative_error(drawn, table.measured) ** 2))
    # Standard error of the rms of n * 27 draws, four times.
    assert rms == pytest.approx(found.relative, rel=4.0 / np.sqrt(2.0 * n * 27))


def test_a_rate_that_is_not_printed_is_refused():
    with pytest.raises(ValueError, match="1 Hz and 2 Hz"):
        read_experiment(3.0)


def test_every_test_is_left_out_once_with_its_controller_and_once_with_its_motion():
    counts = np.bincount([test for fold in FOLDS for test in fold], minlength=len(TESTS))
    assert counts.tolist() == [2] * len(TESTS)


def test_the_nominal_loop_keeps_the_bounds_of_a_linear_drive(loops):
    for rate, simulated in loops.items():
        metrics = simulated.metrics([MACHINE.build(MACHINE.nominal()).finished()])[0]
        exact = np.sqrt(np.maximum(metrics**2 - quantisation() ** 2, 0.0))
        table = replace(read_experiment(rate), measured=exact + 1e-12)
        found = observations(table, scatter(read_experiment(2.0)))
        for o in found:
            if o.kind == "superposition":
                # Half a cycle from rest leaves less than 1e-3 of a transient.
                assert o.value == pytest.approx(0.5, abs=2e-3)
            if o.kind == "torque bound":
                assert o.value <= o.expected * (1.0 + 1e-3)


def test_dry_friction_of_the_collar_breaks_superposition_as_the_1_hz_table_does(loops):
    values = {"level_collar": 0.15, "width": 0.7}
    table = planted(loops, 1.0, "friction.coulomb", values, "smoothed sign")
    found = observations(table, scatter(read_experiment(2.0)))
    ratios = [o.value for o in found if o.kind == "superposition" and "e_u" in o.quantity]
    assert min(ratios) > 0.55


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("friction.viscous", {"viscous_left": 2e-3, "viscous_right": 4e-3, "viscous_collar": 1e-3}),
        ("inertia.payload", {"extra_collar_mass": 0.8, "extra_collar_inertia": 1e-3}),
    ],
)
def test_a_planted_effect_is_recovered_and_carries_over(loops, effect, values):
    at_2_hz, at_1_hz = (planted(loops, rate, effect, values) for rate in (2.0, 1.0))
    fits = fitter(loops, at_2_hz)
    nominal, retuned = diagnosis.nominal_fit(fits), fits.fit(Hypothesis())
    found = fits.fit(Hypothesis(forms=(form(effect),)), retuned)
    assert found.rms < WELL_FITTED < retuned.rms
    checked = carry_over(fits, fitter(loops, at_1_hz), nominal, retuned, found, seed=1)
    assert checked.after < WELL_FITTED < checked.before


def test_equal_weights_leave_a_fit_where_it_is(loops):
    fits = fitter(loops, planted(loops, 2.0, "friction.viscous", {"viscous_collar": 2e-3}))
    found = fits.fit(Hypothesis(forms=(form("friction.viscous"),)), fits.fit(Hypothesis()))
    again = fits.reweighted(found, [np.ones(len(TESTS))])[0]
    before, after = (np.sum(fits.errors(f) ** 2) for f in (found, again))
    assert after <= before + 1e-4


def test_what_fails_on_the_held_out_table_is_withdrawn():
    def ranked(forms, rms, probability):
        fit = SimpleNamespace(
            hypothesis=SimpleNamespace(
                forms=forms,
                ids=tuple(forms),
                label=" + ".join(forms) or "retuned nominal",
                contained=frozenset(forms),
                rough=False,
            ),
            held_out_rms=rms,
        )
        return SimpleNamespace(fit=fit, probability=probability, gain_interval=(0.5, 1.0))

    ranking = [ranked(("friction.presliding",), 0.07, 0.99), ranked((), 0.20, 0.01)]
    accepted = diagnosis._checked(ranking, [0.1, 0.14], [False, False], 0.069)
    assert accepted.verdict == "explained"
    withdrawn = diagnosis._checked(ranking, [0.58, 0.14], [True, False], 0.069)
    assert withdrawn.verdict == "unexplained"
    assert withdrawn.accepted is None
    assert "1 Hz" in withdrawn.reason


def test_the_diagnosis_keeps_its_contract_and_writes_a_self_contained_page(tmp_path):
    result = diagnosis.diagnose_thesis(
        candidates=("inertia.payload", "actuator.torque_constant"), seed=4
    )
    json_path, page_path = result.save(tmp_path)
    document = json.loads(json_path.read_text())
    assert document["verdict"] == "unexplained"
    assert document["effects"] == []
    for shares in ("signals", "regimes", "controllers", "tests"):
        assert sum(row["share"] for row in document["location"][shares]) == pytest.approx(1.0)
    assert sum(row["probability"] for row in document["ranking"]) == pytest.approx(1.0, abs=0.01)
    assert len(document["entries"]) == 2 * len(TESTS) * len(METRICS)
    assert document["shrinkage"]["after"] == document["shrinkage"]["retuned"]
    page = page_path.read_text()
    assert "<svg" in page
    assert "unexplained" in page
    assert not any(mark in page for mark in ('src="http', 'href="http', "@import"))


@pytest.mark.slow
def test_no_effect_of_the_catalogue_explains_the_printed_experiment():
    result = diagnosis.diagnose_thesis()
    assert result.verdict.verdict == "unexplained"
    assert result.best.hypothesis.ids == ("friction.presliding",)
    assert result.refuted[0]
    assert result.location["controllers"][0]["name"] == "ct"

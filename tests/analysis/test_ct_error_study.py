"""Which setting reproduces the printed errors of computed torque: the claims of the study."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from gapscope.analysis import ct_error_study, ct_error_variants
from gapscope.analysis.ct_error_variants import BASE, HELD, HELD_EULER
from gapscope.analysis.files import output_folder
from gapscope.models import benchmark, c_drive
from gapscope.models.c_drive import CDriveParameters
from gapscope.models.observer import continuous_observer, minimum_order_observer

P = CDriveParameters()


def trial(setting):
    return ct_error_study.judge("test", "", ct_error_variants.block_metrics(setting, P))


def test_setting_found_meets_every_printed_rms():
    found = trial(BASE)
    assert found.matched == len(ct_error_study.TARGETS) == 21
    assert found.reproduces


@pytest.mark.parametrize(
    "setting",
    [
        replace(BASE, wiring=BASE.wiring._replace(dead_zone=0.0)),
        replace(BASE, inertia_factor=1.05, damping_factor=1.05),
        replace(BASE, inertia_factor=1.0),
        HELD,
    ],
    ids=["no dead zone", "model error of the other sign", "no error in M", "signals held"],
)
def test_each_part_of_the_setting_is_needed(setting):
    assert not trial(setting).reproduces


def test_held_signals_with_an_euler_observer_are_the_other_reading():
    assert trial(HELD_EULER).reproduces


def test_printed_pd_and_ts_simulation_contradicts_a_law_that_sees_the_whole_error():
    simulated = [b for b in ct_error_study.gain_bounds() if b.source == "thesis_sim"]
    assert len(simulated) == 4
    for bound in simulated:
        assert bound.excess_counts > 5.0 * bound.rounding_counts
        assert bound.excess_counts < 1.0  # a dead zone of one count is wide enough


def test_dead_zone_fitted_to_pd_and_ts_is_one_count_and_predicts_ct():
    fit = ct_error_study.fit_dead_zone(P)
    assert fit.dead_zone_counts == pytest.approx(1.0, abs=0.05)
    assert fit.rms_deviation < 0.005
    for key in ("ct translation e_u_rms_mm", "ct helical e_u_rms_mm"):
        ours, printed = fit.predicted[key]
        assert ours == pytest.approx(printed, rel=0.02)


def test_no_setting_meets_the_maxima_of_table_5_8_not_even_for_pd():
    """Why Table 5-8 cannot choose between settings: what it says of PD is as far off as of CT."""
    values = benchmark.benchmark_metrics(c_drive.drive(P), benchmark.thesis_controllers(P))
    assert values["pd", "rotation", "tau_max_Nm"] < 0.85 * 2.3623
    assert values["ct", "rotation", "tau_max_Nm"] < 0.85 * 2.3233


def test_taylor_observer_of_high_order_is_the_exact_one():
    exact = minimum_order_observer(P, (-600.0, -600.0), 1e-3)
    cut_off = ct_error_variants.taylor_observer(P, 1e-3, 25)
    for a, b in zip(cut_off, exact):
        np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-10 * np.abs(b).max())


def test_euler_equivalent_makes_the_euler_step():
    dt = 1e-3
    observer = continuous_observer(P, (-600.0, -600.0))
    equivalent = ct_error_variants.euler_equivalent(observer, dt)
    transition = expm(dt * equivalent.from_state)
    held = np.linalg.solve(equivalent.from_state, transition - np.eye(2))
    np.testing.assert_allclose(transition, np.eye(2) + dt * observer.from_state, atol=1e-12)
    np.testing.assert_allclose(
        held @ equivalent.from_position, dt * observer.from_position, rtol=1e-10
    )


def test_study_writes_its_table(tmp_path):
    study = ct_error_study.Study(
        bounds=ct_error_study.gain_bounds(),
        fit=ct_error_study.DeadZoneFit(
            beta=4e-3, gamma=3e-3, dead_zone_counts=1.0, rms_deviation=0.0, predicted={}
        ),
        trials=tuple(
            ct_error_study.judge(v.group, v.label, v.simulate())
            for v in ct_error_variants.variants(P)
            if v.group in ("as found", "sampled loop")
        ),
        provenance={},
    )
    paths = ct_error_study.write_study(study, output_folder(tmp_path / "new"))
    assert [path.name for path in paths] == ["ct_errors.json", "ct_errors.md"]
    assert "| as found |" in paths[1].read_text()


@pytest.mark.slow
def test_every_setting_that_meets_the_table_has_a_dead_zone_and_too_little_inertia():
    study = ct_error_study.run_study(P)
    found = [t for t in study.trials if t.reproduces]
    assert len(found) >= 3
    assert all(ct_error_study.has_dead_zone(t) for t in found)
    surviving = {t.label for t in found if t.group == "model error"}
    assert surviving == {"M × 0.95, D × 1"}

"""Table 4.1 from the velocity profile of section 4.1.2."""

import pytest

from gapscope.analysis.mechatronic import friction_identification as study
from gapscope.models.servo_axis import ServoAxis


@pytest.fixture(scope="module")
def data():
    return study.measure(ServoAxis(), noise=0.01, seed=0)


def test_table_4_1_is_recovered(data):
    """Seed 0, 0.01 N m of noise; beta, which acts below 0.1 rad/s, is the hard one."""
    found = study.identify(data)
    for name, printed in study.PRINTED.items():
        error = abs(found.values[name] - printed)
        assert error < 4.0 * found.deviations[name]
        assert error < (0.5 if name == "sign_rate" else 0.01) * printed


def test_tanh_of_the_filtered_rate_blurs_the_reversal(data):
    """The procedure as printed takes a smoother sign for the friction: beta far too small."""
    as_printed = study.identify(data, filter_regressors=False)
    assert as_printed.rms > study.identify(data).rms
    assert as_printed.values["coulomb"] == pytest.approx(0.478, rel=0.05)


def test_profile_reaches_its_printed_speeds():
    rates = study.profile()
    assert abs(rates).max() == pytest.approx(3700.0 * 3.14159265 / 30.0)
    assert {-1.0, 1.0} <= set(rates / abs(rates).clip(1e-9))

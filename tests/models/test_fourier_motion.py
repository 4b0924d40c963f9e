import numpy as np
import pytest

from gapscope.models.fourier_motion import FourierMotion, load_motion

MOTION = FourierMotion(
    name="m", period=0.8, cycles=2, cosine=((-8.0, 2.0),) * 2, sine=((2.0, -1.0), (-4.0, 2.0))
)


def test_a_cycle_starts_and_ends_at_rest_and_rates_are_derivatives():
    for values in MOTION.sample([0.0, 0.8, 1.6]):
        np.testing.assert_allclose(values, 0.0, atol=1e-9)
    t, h = np.linspace(0.0, 0.8, 50), 1e-5
    before, at, after = (MOTION.sample(t + d) for d in (-h, 0.0, h))
    # Central differences are off by h^2/6 times the third derivative, at most two terms of 8 w^3 8 here.
    bound = h**2 / 6 * 256 * (2 * np.pi / 0.8) ** 4
    np.testing.assert_allclose((after[0] - before[0]) / (2 * h), at[1], atol=bound)
    np.testing.assert_allclose((after[1] - before[1]) / (2 * h), at[2], atol=10 * bound)


def test_a_saved_motion_is_read_back(tmp_path):
    MOTION.save(tmp_path / "m.yaml")
    assert load_motion(tmp_path / "m.yaml") == MOTION


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("period: 0.8", "period: -1"), "period"),
        (("period: 0.8", "period: fast"), "period"),
        (("cycles: 2", "cycles: 0"), "cycles"),
        (("name: m", "title: m"), "expected keys"),
        (("- - -8.0", "- - -9.0"), "acceleration"),
        (("- - 2.0", "- - 3.0"), "speed"),
    ],
)
def test_a_bad_motion_is_named_by_file_and_key(tmp_path, change, words):
    text = MOTION.text()
    assert change[0] in text
    (tmp_path / "m.yaml").write_text(text.replace(*change))
    with pytest.raises(ValueError, match=rf"m\.yaml.*{words}"):
        load_motion(tmp_path / "m.yaml")

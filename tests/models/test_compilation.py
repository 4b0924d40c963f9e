"""The compiled kernels follow the laws: their cache is named after what the laws say."""

import numba
import pytest
from numba.core import config

from gapscope.models import compilation, friction


@pytest.fixture
def copied_laws(tmp_path, monkeypatch):
    (tmp_path / "friction.py").write_text("# a law\n")
    monkeypatch.setattr(compilation, "__file__", str(tmp_path / "compilation.py"))
    compilation._cache_folder.cache_clear()
    yield tmp_path / "friction.py"
    compilation._cache_folder.cache_clear()


def test_a_changed_law_gets_a_cache_of_its_own(copied_laws):
    before = compilation._cache_folder()
    compilation._cache_folder.cache_clear()
    copied_laws.write_text("# another law\n")
    assert compilation._cache_folder() != before


def test_the_setting_of_numba_is_left_as_it_was():
    before = config.CACHE_DIR

    @compilation.kernel
    def kernel(x):
        return friction.viscous(x, 2.0, 0.0)

    assert isinstance(kernel, numba.core.registry.CPUDispatcher)
    assert before == config.CACHE_DIR


def test_a_kernel_computes_what_the_law_says():
    @numba.njit
    def kernel(v):
        return friction.dry(v, 1.0, 2.0, 0.5, 3.0, 0.1)

    compilation.register_laws(friction)
    for v in (-4.0, -0.05, 0.0, 0.2, 7.0):
        assert kernel(v) == pytest.approx(friction.dry(v, 1.0, 2.0, 0.5, 3.0, 0.1), rel=1e-15)

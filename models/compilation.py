"""The boundary to numba: laws stay plain Python, kernels that call them are compiled.

A law is written once, as a plain function. A kernel module registers the laws it calls and turns
its own loops into machine code:

>>> from gapscope.models import compilation, friction
>>> compilation.register_laws(friction)
>>> @compilation.kernel
... def total(speeds, width):
...     sum_ = 0.0
...     for i in range(speeds.size):
...         sum_ += friction.smooth_sign(speeds[i], width)
...     return sum_

numba's disk cache looks only at the file of the kernel itself and would keep a kernel whose law
has changed in another file. The cache folder is therefore named after the contents of all law modules.
"""

import hashlib
import inspect
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
import platformdirs
from numba.core import config as numba_config
from numba.extending import register_jitable

from . import elementary_compiled as elementary_compiled  # kernels need it

# numba sets its options as module attributes at import, out of sight of type checkers.
config: Any = numba_config


# Products may be added without rounding and divisors inverted beforehand: neither changes more than the last
# bits, nor what is made of infinities and NaN. Sums keep their order.
FAST: Any = {"contract", "arcp"}


def register_laws(*modules: ModuleType) -> None:
    """Let kernels call the functions of these law modules, which stay plain Python."""
    for module in modules:
        for law in vars(module).values():
            if inspect.isfunction(law) and law.__module__ == module.__name__:
                _register(law)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile a module-level function for float arguments, cached on disk, without the GIL."""
    return _compiled(function)


def part(function: Callable[..., Any]) -> Any:
    """As ``kernel``, for what other kernels do sample by sample: they have it in place of a call."""
    return _compiled(function, forceinline=True)


def _compiled(function: Callable[..., Any], **options: Any) -> Any:
    before = config.CACHE_DIR
    config.CACHE_DIR = str(_cache_folder())
    try:
        return numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST, **options)(
            function
        )
    finally:
        config.CACHE_DIR = before


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Let kernels have the lines of this function in place, as arrays of ``stack`` need it."""
    return register_jitable(inline="always")(function)


@cache
def _register(law: Callable[..., Any]) -> None:
    # Inlined, a law takes the arrays of a plant where they are; as a call it would copy them all.
    register_jitable(error_model="numpy", forceinline=True, fastmath=FAST)(law)


@cache
def _cache_folder() -> Path:
    """``$NUMBA_CACHE_DIR`` or the user's cache, then a name made of all that kernels depend on."""
    digest = hashlib.sha256(f"{sys.version}{numba.__version__}".encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(source.read_bytes())
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("gapscope")
    return Path(base) / f"kernels-{digest.hexdigest()[:16]}"

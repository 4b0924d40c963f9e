"""What lets one law serve float, AutoDiffXd and Expression contexts, and constants live in a Context."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import BasicVector_, LeafSystem


class NeverZero:
    """A constant that claims to differ from zero, so that a law evaluates its effect.

    The laws skip an effect whose constant is zero. For AutoDiffXd that would lose the derivative by
    the constant, and an Expression cannot answer. Sums and products return the bare value.
    """

    def __init__(self, value: Any) -> None:
        self.value = value

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        return False

    def __ne__(self, other: object) -> bool:
        return True

    def __add__(self, other: Any) -> Any:
        return self.value + _bare(other)

    def __radd__(self, other: Any) -> Any:
        return _bare(other) + self.value

    def __sub__(self, other: Any) -> Any:
        return self.value - _bare(other)

    def __mul__(self, other: Any) -> Any:
        return self.value * _bare(other)

    def __rmul__(self, other: Any) -> Any:
        return _bare(other) * self.value


def _bare(value: Any) -> Any:
    return value.value if isinstance(value, NeverZero) else value


def declare_parameter(system: Any, values: ArrayLike, scalar: Any = float) -> int:
    """Declare ``values``, flattened by rows, as one numeric parameter; returns its index."""
    flat = [scalar(value) for value in np.asarray(values, dtype=float).ravel()]
    return int(system.DeclareNumericParameter(BasicVector_[scalar](flat)))


def parameter(context: Any, index: int, *shape: int) -> NDArray[Any]:
    """A copy of numeric parameter ``index`` as an array of this shape."""
    return np.array(context.get_numeric_parameter(index).CopyToVector()).reshape(shape)


def set_parameter(context: Any, index: int, values: ArrayLike) -> None:
    """Set numeric parameter ``index`` from an array of any shape with as many entries."""
    context.get_mutable_numeric_parameter(index).SetFromVector(np.asarray(values).ravel())


def constants(context: Any, index: int) -> Any:
    """Numeric parameter ``index`` as it stands in this context, flat, not to be written to."""
    return context.get_numeric_parameter(index).value()


def signal(system: Any, context: Any, port: str) -> Any:
    """Value of the named input port in this context."""
    return system.GetInputPort(port).Eval(context)


def numbered(system: Any, context: Any, port: int) -> Any:
    """Value of a vector input port by its index, which is twice as fast as by its name."""
    return system.EvalVectorInput(context, port).value()


def positive(owner: LeafSystem, name: str, value: float, unit: str) -> float:
    """``value`` if it is positive and finite; ValueError that names the system and field otherwise."""
    if not (value > 0.0 and math.isfinite(value)):
        raise ValueError(
            f"{type(owner).__name__}: {name} is {value}; expected a positive number [{unit}]"
        )
    return value

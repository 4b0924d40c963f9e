"""A drive's constants and state in arrays of known size, which compiled loops keep in registers."""

from functools import cache
from typing import Any, NamedTuple

from . import compilation, stack
from .drive import (
    BREAKAWAY,
    COUPLING_COLUMNS,
    DELAY,
    ELEMENT_COLUMNS,
    FADE,
    LAG,
    LOAD_FRICTION,
    NET_LOAD_FRICTION,
    RIPPLE_COS,
    RIPPLE_SIN,
    SHAFT_COLUMNS,
    STIFFNESS,
    VISCOUS_SKEW,
    Drive,
)


class Sizes(NamedTuple):
    """The numbers of a drive's parts, for ``stack``."""

    shafts: stack.Axis
    elements: stack.Axis
    couplings: stack.Axis
    rare: stack.Axis  # empty for a drive without rare effects: the compiler leaves their lines out


def sizes(plant: Drive, rare: bool = True) -> Sizes:
    """Sizes of a drive's arrays, and whether it may have rare effects."""
    return _sizes(plant.elements.shape, len(plant.coupling), rare)


@cache
def _sizes(elements: tuple[int, int], couplings: int, rare: bool) -> Sizes:
    m, n = elements
    return Sizes(stack.axis(n), stack.axis(m), stack.axis(couplings), stack.axis(rare))


@compilation.kernel
def has_rare_effects(element: Any, shaft: Any) -> bool:
    """Whether ``Drive.element`` and ``shaft`` hold an effect beyond viscous and dry friction, bias, gain and limit."""
    for i in range(element.shape[0]):
        row = element[i]
        if row[VISCOUS_SKEW] != 0.0 or row[BREAKAWAY] != 0.0 or row[STIFFNESS] != 0.0:
            return True
        if row[FADE] != 0.0:
            return True
    for j in range(shaft.shape[0]):
        row = shaft[j]
        if row[LOAD_FRICTION] != 0.0 or row[NET_LOAD_FRICTION] != 0.0:
            return True
        if row[RIPPLE_COS] != 0.0 or row[RIPPLE_SIN] != 0.0:
            return True
        if row[DELAY] != 0.0 or row[LAG] != 0.0:
            return True
    return False


STAGES = stack.axis(2)
ELEMENT, SHAFT, COUPLING = map(stack.axis, (ELEMENT_COLUMNS, SHAFT_COLUMNS, COUPLING_COLUMNS))


@compilation.inlined
def plant_on_stack(given: Drive, sizes: Sizes) -> Drive:
    """The drive in arrays on the stack."""
    plant = Drive(
        stack.matrix(sizes.shafts, sizes.shafts, given.inertia_inverse),
        stack.matrix(sizes.elements, sizes.shafts, given.elements),
        stack.matrix(sizes.elements, ELEMENT, given.element),
        stack.matrix(sizes.shafts, SHAFT, given.shaft),
        stack.matrix(sizes.couplings, COUPLING, given.coupling),
    )
    stack.copy(given.inertia_inverse, plant.inertia_inverse)
    stack.copy(given.elements, plant.elements)
    stack.copy(given.element, plant.element)
    stack.copy(given.shaft, plant.shaft)
    stack.copy(given.coupling, plant.coupling)
    if len(sizes.rare) == 0:
        _without_rare_effects(plant)
    return plant


@compilation.inlined
def _without_rare_effects(plant: Drive) -> None:
    """Zeros that the compiler knows, so that it finds these effects left out."""
    stack.clear(plant.element, VISCOUS_SKEW)
    stack.clear(plant.element, BREAKAWAY)
    stack.clear(plant.element, STIFFNESS)
    stack.clear(plant.element, FADE)
    stack.clear(plant.shaft, LOAD_FRICTION)
    stack.clear(plant.shaft, NET_LOAD_FRICTION)
    stack.clear(plant.shaft, RIPPLE_COS)
    stack.clear(plant.shaft, RIPPLE_SIN)
    stack.clear(plant.shaft, DELAY)
    stack.clear(plant.shaft, LAG)


@compilation.inlined
def state_on_stack(sizes: Sizes, actuated: stack.Axis, like: Any) -> tuple[Any, ...]:
    """What ``rest`` and ``drive.work_arrays`` give, with positions before them, on the stack."""
    n, m = sizes.shafts, sizes.elements
    stages = (
        stack.vector(n, like),
        stack.vector(n, like),
        stack.vector(n, like),
        stack.vector(n, like),
        stack.vector(n, like),
    )
    return (
        stack.vector(n, like),
        stack.vector(n, like),
        stack.vector(m, like),
        stack.vector(m, like),
        stack.matrix(STAGES, actuated, like),
        stack.vector(n, like),
        (stack.vector(n, like), stages),
    )

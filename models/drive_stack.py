"""A drive's constants and state in arrays of known size, which compiled loops keep in registers."""

from typing import Any, NamedTuple

from . import compilation, stack
from .drive import COUPLING_COLUMNS, ELEMENT_COLUMNS, SHAFT_COLUMNS, Drive


class Sizes(NamedTuple):
    """The numbers of a drive's parts, for ``stack``."""

    shafts: stack.Axis
    elements: stack.Axis
    couplings: stack.Axis


def sizes(plant: Drive) -> Sizes:
    """Sizes of a drive's arrays."""
    m, n = plant.elements.shape
    return Sizes(stack.axis(n), stack.axis(m), stack.axis(len(plant.coupling)))


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
    _copy(given.inertia_inverse, plant.inertia_inverse)
    _copy(given.elements, plant.elements)
    _copy(given.element, plant.element)
    _copy(given.shaft, plant.shaft)
    _copy(given.coupling, plant.coupling)
    return plant


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


@compilation.inlined
def _copy(source: Any, target: Any) -> None:
    for i in range(target.shape[0]):
        for j in range(target.shape[1]):
            target[i, j] = source[i, j]


@compilation.inlined
def memory_on_stack(sensors: stack.Axis, like: Any) -> tuple[Any, ...]:
    """The eight rows of a controller's memory on the stack, zero."""
    return (
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
    )

"""A drive's constants and state in arrays of known size, which compiled loops keep in registers."""

from typing import Any, NamedTuple

from . import compilation, stack
from .drive import Drive


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
ELEMENT_COLUMNS, SHAFT_COLUMNS, COUPLING_COLUMNS = stack.axis(10), stack.axis(11), stack.axis(5)


@compilation.inlined
def plant_on_stack(given: Drive, sizes: Sizes) -> Drive:
    """The drive in arrays on the stack."""
    plant = Drive(
        stack.matrix(sizes.shafts, sizes.shafts),
        stack.matrix(sizes.elements, sizes.shafts),
        stack.matrix(sizes.elements, ELEMENT_COLUMNS),
        stack.matrix(sizes.shafts, SHAFT_COLUMNS),
        stack.matrix(sizes.couplings, COUPLING_COLUMNS),
    )
    _copy(given.inertia_inverse, plant.inertia_inverse)
    _copy(given.elements, plant.elements)
    _copy(given.element, plant.element)
    _copy(given.shaft, plant.shaft)
    _copy(given.coupling, plant.coupling)
    return plant


@compilation.inlined
def state_on_stack(sizes: Sizes, actuated: stack.Axis) -> tuple[Any, ...]:
    """What ``rest`` and ``drive.work_arrays`` give, with positions before them, on the stack."""
    n, m = sizes.shafts, sizes.elements
    stages = (
        stack.vector(n),
        stack.vector(n),
        stack.vector(n),
        stack.vector(n),
        stack.vector(n),
    )
    return (
        stack.vector(n),
        stack.vector(n),
        stack.vector(m),
        stack.vector(m),
        stack.matrix(STAGES, actuated),
        stack.vector(n),
        (stack.vector(n), stages),
    )


@compilation.inlined
def _copy(source: Any, target: Any) -> None:
    for i in range(target.shape[0]):
        for j in range(target.shape[1]):
            target[i, j] = source[i, j]


@compilation.inlined
def memory_on_stack(sensors: stack.Axis) -> tuple[Any, ...]:
    """The eight rows of a controller's memory on the stack, zero."""
    return (
        stack.vector(sensors),
        stack.vector(sensors),
        stack.vector(sensors),
        stack.vector(sensors),
        stack.vector(sensors),
        stack.vector(sensors),
        stack.vector(sensors),
        stack.vector(sensors),
    )

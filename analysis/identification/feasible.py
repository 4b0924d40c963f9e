r"""Least squares over bodies that can exist, as a semidefinite program.

.. math:: \min \|W \phi - f\|_\Sigma^2 + \sum_k ((\phi_k - \phi_{0k}) / \tau_k)^2

with masses, planar inertias and friction at least zero; tensors about a centre of mass with
:math:`\frac12 tr(I) 1 - I \succeq 0` (triangle inequalities); ten parameters of a body with a positive semidefinite
pseudo-inertia (Wensing, Kim and Slotine 2018, IEEE RA-L 3, 60). The prior fills what the forces do not show: tau is
2 % of a trusted parameter and 50 % of any other; friction has none.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from ...models.parallel.rotation import ENTRIES, inertia_tensor
from .machine import Machine
from .measurement import Regression

Floats = NDArray[np.float64]

TRUSTED, OTHER = 0.02, 0.5


class InfeasibleError(RuntimeError):
    """The solver found no feasible parameters."""


def feasible(machine: Machine, data: Regression, scatter: Floats) -> Floats:
    """Parameters (p + 2n,) that can exist; ``scatter`` (n,) is the residual deviation of each axis."""
    weight = 1.0 / scatter[data.axis]
    scale = _scale(machine, data)
    _, stacked = np.linalg.qr(
        np.column_stack([data.regressor * scale * weight[:, None], data.force * weight])
    )
    triangle, target = stacked[:, :-1], stacked[:, -1]
    program = MathematicalProgram()
    x = program.NewContinuousVariables(len(machine.names), "x")
    # Scaled to a residual of order one, which the solver's tolerances expect.
    size = np.sqrt(len(data.force))
    program.Add2NormSquaredCost(triangle / size, target / size, x)
    known, width = _prior(machine)
    count = known.size
    program.Add2NormSquaredCost(np.eye(count) / size, known / width / size, x[:count])
    with np.errstate(invalid="ignore"):  # symbolic products raise the flag without a cause
        _constrain(machine, program, scale * x)
    result = ClarabelSolver().Solve(program)
    if not result.is_success():
        raise InfeasibleError(f"{machine.name}: {result.get_solution_result()}")
    return np.asarray(scale * result.GetSolution(x), dtype=float)


def smallest_margins(machine: Machine, values: Floats) -> dict[str, float]:
    """Smallest scalar parameter and smallest eigenvalue of the bodies' matrices; negative is unphysical."""
    in_blocks = {i for block in (*machine.tensors, *machine.bodies) for i in block}
    scalars = [v for i, v in enumerate(values) if i not in in_blocks]
    matrices = [_triangle_matrix(values[list(b)]) for b in machine.tensors]
    matrices += [_pseudo_inertia(values[list(b)]) for b in machine.bodies]
    found = {"smallest_scalar": float(min(scalars))}
    if matrices:
        found["smallest_eigenvalue"] = float(min(np.linalg.eigvalsh(m)[0] for m in matrices))
    return found


def _constrain(machine: Machine, program: MathematicalProgram, values: Any) -> None:
    in_blocks = {i for block in (*machine.tensors, *machine.bodies) for i in block}
    for i in range(len(machine.names)):
        if i not in in_blocks:
            program.AddLinearConstraint(values[i] >= 0.0)
    for block in machine.tensors:
        program.AddPositiveSemidefiniteConstraint(_triangle_matrix(values[list(block)]))
    for block in machine.bodies:
        program.AddPositiveSemidefiniteConstraint(_pseudo_inertia(values[list(block)]))


def _triangle_matrix(entries: Any) -> Any:
    """Tr(I)/2 1 - I (3, 3) of tensor entries (6,): the second moments of mass."""
    tensor = _symmetric(entries)
    half = 0.5 * (entries[0] + entries[1] + entries[2])
    return half * np.eye(3) - tensor


def _pseudo_inertia(ten: Any) -> Any:
    """Pseudo-inertia (4, 4) of ten parameters m, h, I about the origin."""
    out = np.empty((4, 4), dtype=np.asarray(ten).dtype)
    out[:3, :3] = _triangle_matrix(ten[4:])
    out[:3, 3] = out[3, :3] = ten[1:4]
    out[3, 3] = ten[0]
    return out


def _symmetric(entries: Any) -> Any:
    if np.asarray(entries).dtype != object:
        return inertia_tensor(entries)
    out = np.empty((3, 3), dtype=object)
    for k, (i, j) in enumerate(ENTRIES):
        out[i, j] = out[j, i] = entries[k]
    return out


def _prior(machine: Machine) -> tuple[Floats, Floats]:
    """Known values and widths (p,); what is zero by drawing is as uncertain as the parameters beside it."""
    known = machine.prior
    share = np.array([TRUSTED if name in machine.trusted else OTHER for name in machine.parameters])
    size = np.abs(known)
    for block in machine.tensors:
        size[list(block)] = np.maximum(size[list(block)], 0.2 * size[list(block)[:3]].max())
    for block in machine.bodies:
        ten = size[list(block)]
        size[list(block)] = np.maximum(ten, [1e-3, *([1e-3] * 3), *([1e-5] * 6)])
    return known, share * np.maximum(size, 1e-9)


def _scale(machine: Machine, data: Regression) -> Floats:
    _, width = _prior(machine)
    friction = np.maximum(np.concatenate([machine.coulomb, machine.viscous]), 1e-6)
    return np.concatenate([width, friction])

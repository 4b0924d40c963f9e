"""The robots of ``mechanisms``: each as reduced model, projected plant and discrete plant, and its displacement analyses."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...models import compilation
from ...models.mm3a import dynamics as arm_dynamics
from ...models.mm3a import kinematics as arm_kinematics
from ...models.mm3a.arm import Arm, gravity_in_base
from ...models.parallel import chains, mast
from ...models.parallel.chain import Chain
from ...models.parallel.five_bar import FiveBar
from ...models.parallel.machine import FiveBarMachine, ParallelMachine, TableMachine
from ...models.pmc import constants, kinematics, simulation
from ...models.pmc import dynamics as pmc_dynamics
from ...models.pmc.constants import Constants
from ...models.pmc.parameters import Counterweight, PMCParameters

Floats = NDArray[np.float64]
Law = Callable[[Floats, Floats, Floats], Floats]  # accelerations (n,) of q, v and forces (n,)


@dataclass(frozen=True)
class Robot:
    """One robot, its joints q (n,), a posture and the forces of the task."""

    name: str
    start: Floats
    push: Floats  # accelerations [rad/s^2 or m/s^2] at the start
    needed: Law  # forces (n,) of q, v and accelerations
    reduced: Callable[[Floats, Floats, int, float], Floats]  # positions after ODE4 from rest
    projected: Law
    discrete: (
        Callable[[Floats, Floats, int, float], Callable[[], Floats]] | None
    )  # a run of the SAP plant
    spread: Floats  # of ``postures`` about the start, in the joints
    there_and_back: Callable[[Floats], Floats]  # inverse of forward
    without_sap: str = ""  # why there is no discrete plant

    def force(self) -> Floats:
        """Forces that give ``push`` at the start."""
        return self.needed(self.start, np.zeros(len(self.start)), self.push)

    def postures(self, count: int) -> Floats:
        """Joint positions (count, n) about the start."""
        unit = np.random.default_rng(8).uniform(-1.0, 1.0, (count, len(self.start)))
        return self.start + self.spread * unit


def robots() -> list[Robot]:
    """PMC, 5R, MAST and MM3A."""
    five = FiveBarMachine(geometry=replace(FiveBar(), weight=9.81))
    table = TableMachine(table=mast.MAST)
    return [
        _pmc(),
        _parallel(
            "5R", five, chains.five_bar(five.geometry), [1.95, 1.05], [3.0, -2.0], [0.2, 0.2]
        ),
        _parallel(
            "MAST", table, chains.mast(table.table), [0.0] * 3, [0.3, -0.2, 0.1], [0.005] * 3
        ),
        _mm3a(),
    ]


def ode4(law: Law, start: Floats, force: Floats, samples: int, h: float) -> Floats:
    """Positions (n,) after ``samples`` Runge-Kutta steps of ``h`` seconds from rest; ``law`` gives accelerations of (q, v, force)."""
    q, v = start, np.zeros(len(start))
    for _ in range(samples):
        a1 = law(q, v, force)
        v2 = v + 0.5 * h * a1
        a2 = law(q + 0.5 * h * v, v2, force)
        v3 = v + 0.5 * h * a2
        a3 = law(q + 0.5 * h * v2, v3, force)
        v4 = v + h * a3
        a4 = law(q + h * v3, v4, force)
        q, v = (
            q + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4),
            v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
        )
    return q


@compilation.kernel
def _move_pmc(start: Any, force: Any, samples: int, dt: float, c: Constants) -> Any:
    w, v = (start[0], start[1], start[2], start[3]), (0.0, 0.0, 0.0, 0.0)
    push = (force[0], force[1], force[2], force[3])
    for _ in range(samples):
        w, v = simulation.ode4_step(w, v, push, dt, c)
    return w


def _pmc() -> Robot:
    from ...systems import pmc_plant

    p = replace(PMCParameters(), counterweight=Counterweight(mass=0.0))
    c, tree = constants.of(p), pmc_plant.ProjectedPlant(p)
    centre = 0.5 * (p.geometry.carriage_min + p.geometry.carriage_max)
    start = np.array([centre, centre, 0.3, np.pi / 2 - 0.3])

    def discrete(q: Floats, force: Floats, samples: int, dt: float) -> Callable[[], Floats]:
        plant = pmc_plant.discrete_plant(p, dt)
        near = pmc_plant.tree_positions(q, plant, p.geometry)
        return _discrete_run(plant, near, pmc_plant.DRIVEN, force, samples, dt)

    return Robot(
        "PMC", start, np.array([1.0, -1.0, 4.0, 3.0]),
        lambda w, v, a: np.array(pmc_dynamics.inverse_dynamics(w, v, a, c)),
        lambda q, force, samples, dt: np.array(_move_pmc(q, force, samples, dt, c)),
        lambda w, v, force: tree.project(w, v).acceleration(force), discrete,
        np.array([0.02, 0.02, 0.1, 0.1]),
        lambda w: kinematics.inverse(kinematics.forward(w, p.geometry), p.geometry),
    )  # fmt: skip


def _parallel(
    name: str, machine: ParallelMachine, chain: Any, start: Any, push: Any, spread: Any
) -> Robot:
    from ...systems.closed_chain import ClosedChain, discrete_plant

    tree = ClosedChain(chain)
    last = {"at": tree.close(np.array(start))}  # the loops are closed from where they were

    def projected(q: Floats, v: Floats, force: Floats) -> Floats:
        last["at"] = tree.close(q, near=last["at"])
        at = tree.project(last["at"], v)
        return np.asarray(np.linalg.solve(at.matrix, force - at.bias))

    def reduced(q: Floats, force: Floats, samples: int, dt: float) -> Floats:
        return ode4(lambda q, v, f: machine.equations(q, v).acceleration(f), q, force, samples, dt)

    def discrete(q: Floats, force: Floats, samples: int, dt: float) -> Callable[[], Floats]:
        plant = discrete_plant(_with_inertia(chain), dt)
        return _discrete_run(plant, tree.close(q), chain.driven, force, samples, dt)

    massless = [link.name for link in chain.links if not link.mass and not any(link.inertia)]
    return Robot(
        name, np.array(start), np.array(push),
        lambda q, v, a: machine.equations(q, v).force(a), reduced, projected,
        None if massless else discrete,
        np.array(spread), lambda q: machine.inverse(machine.forward(q)),
        f"SAP takes no massless links: {', '.join(massless)}",
    )  # fmt: skip


def _with_inertia(chain: Chain) -> Chain:
    """SAP needs a moment of inertia of a point mass that turns by itself; about its centre it moves nothing else."""
    links = (
        replace(link, inertia=(1e-9, 1e-9, 1e-9, 0.0, 0.0, 0.0))
        if link.mass > 0.0 and not any(link.inertia)
        else link
        for link in chain.links
    )
    return replace(chain, links=tuple(links))


def _mm3a() -> Robot:
    from pydrake.multibody.plant import MultibodyPlant

    from ...systems.mm3a.plant import add_arm

    arm, down = Arm(), gravity_in_base(0.0, 0.0)
    middle = 0.5 * (np.array(arm.lower) + np.array(arm.upper))
    start = middle + 0.2 * (np.array(arm.upper) - middle)
    tree: Any = MultibodyPlant(0.0)
    add_arm(tree, arm)
    tree.Finalize()
    context = tree.CreateDefaultContext()
    none = (0.0, 0.0, 0.0)

    def needed(q: Floats, v: Floats, a: Floats) -> Floats:
        return np.array(arm_dynamics.effort(q, v, a, down, none, arm))

    def law(q: Floats, v: Floats, force: Floats) -> Floats:
        inertia = np.array(arm_dynamics.mass_diagonal(q, arm))
        return np.asarray((force - needed(q, v, np.zeros(3))) / inertia)

    def plant_law(q: Floats, v: Floats, force: Floats) -> Floats:
        tree.SetPositions(context, q)
        tree.SetVelocities(context, v)
        load = tree.CalcBiasTerm(context) - tree.CalcGravityGeneralizedForces(context)
        return np.asarray(np.linalg.solve(tree.CalcMassMatrix(context), force - load))

    def discrete(q: Floats, force: Floats, samples: int, dt: float) -> Callable[[], Floats]:
        plant = MultibodyPlant(dt)
        add_arm(plant, arm)
        plant.Finalize()
        return _discrete_run(plant, q, ("joint_1", "joint_2", "joint_3"), force, samples, dt)

    def there_and_back(q: Floats) -> Floats:
        tips = arm_kinematics.tip(q.T, arm)
        return np.array([arm_kinematics.inverse(tip, arm) for tip in zip(*tips)])

    return Robot(
        "MM3A", start, np.array([4.0, 3.0, 0.05]), needed,
        lambda q, force, samples, dt: ode4(law, q, force, samples, dt), plant_law, discrete,
        0.1 * (np.array(arm.upper) - middle), there_and_back,
    )  # fmt: skip


def _discrete_run(
    plant: Any, positions: Floats, driven: Any, force: Floats, samples: int, dt: float
) -> Callable[[], Floats]:
    """``samples`` steps of the discrete plant under forces on its driven joints; gives their positions."""
    from pydrake.systems.analysis import Simulator

    joints = [plant.GetJointByName(name) for name in driven]
    forces = np.zeros(plant.num_velocities())
    forces[[joint.velocity_start() for joint in joints]] = force
    at = [joint.position_start() for joint in joints]

    def run() -> Floats:
        simulator = Simulator(plant)
        context = simulator.get_mutable_context()
        plant.get_applied_generalized_force_input_port().FixValue(context, forces)
        plant.SetPositions(context, positions)
        simulator.AdvanceTo(dt * samples)
        return np.asarray(plant.GetPositions(context)[at])

    return run

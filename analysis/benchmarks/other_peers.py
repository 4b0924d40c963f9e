"""The closed loop in other simulators. Each builds its model once and returns a function that runs it.

Raises ImportError where the simulator is not installed.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import peer_laws as laws
from .peer_laws import Constants

Signals = tuple[NDArray[np.float64], NDArray[np.float64]]
Run = Callable[[], Signals]

# Sum and difference of the shafts' angles decouple the inertia. Without contacts and gravity.
MODEL = """<mujoco>
 <option timestep="{dt}" integrator="RK4" gravity="0 0 0"><flag contact="disable"/></option>
 <worldbody>
  <body><joint name="sum" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 {sum}"/></body>
  <body><joint name="gap" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 {gap}"/></body>
 </worldbody>
 <tendon>
  <fixed name="left"><joint joint="sum" coef="0.5"/><joint joint="gap" coef="0.5"/></fixed>
  <fixed name="right"><joint joint="sum" coef="0.5"/><joint joint="gap" coef="-0.5"/></fixed>
 </tendon>
 <actuator><motor tendon="left"/><motor tendon="right"/></actuator>
</mujoco>"""


def mujoco_engine() -> Any:
    """The module of MuJoCo, whose types are not checked. Raises ImportError where it is not installed."""
    import mujoco as engine

    return engine


def mujoco(c: Constants, reference: NDArray[np.float64]) -> Run:
    """MuJoCo with its Runge-Kutta 4; it has no tanh friction, which is a Python callback per stage."""
    engine = mujoco_engine()
    inertias = {"sum": 0.5 * (c.m11 + c.m12), "gap": 0.5 * (c.m11 - c.m12)}
    model = engine.MjModel.from_xml_string(
        MODEL.format(dt=repr(c.dt), **{key: repr(value) for key, value in inertias.items()})
    )
    data = engine.MjData(model)

    def rub(model: Any, data: Any) -> None:
        both, gap = data.qvel
        left, right = laws.friction(c, 0.5 * (both + gap), 0.5 * (both - gap))
        data.qfrc_passive[:] = (-0.5 * (left + right), -0.5 * (left - right))

    def advance(torque: Any) -> None:
        data.ctrl[:] = torque
        engine.mj_step(model, data)

    def angles() -> tuple[float, float]:
        both, gap = data.qpos
        return 0.5 * (both + gap), 0.5 * (both - gap)

    def run() -> Signals:
        engine.mj_resetData(model, data)
        engine.set_mjcb_passive(rub)
        try:
            return _sampled(c, reference, angles, advance)
        finally:
            engine.set_mjcb_passive(None)

    return run


def _sampled(
    c: Constants,
    reference: NDArray[np.float64],
    angles: Callable[[], tuple[float, float]],
    advance: Callable[[Any], None],
) -> Signals:
    """Encoder and controller as a Python loop around a plant that ``advance`` moves by one sample."""
    measured, command = np.empty(reference.shape), np.empty(reference.shape)
    low = [0.0, 0.0]
    for k, wanted in enumerate(reference.tolist()):
        measured[k] = read = laws.read_encoder(c, angles())
        error = laws.difference(wanted, read)
        command[k] = torque = laws.pd(c, error, low)
        low = laws.low_pass(c, error, low)
        advance(torque)
    return measured, command


def python_control(c: Constants, reference: NDArray[np.float64]) -> Run:
    """python-control: plant and controller as sampled nonlinear systems, interconnected."""
    import control

    plant = control.nlsys(
        lambda t, x, u, params: laws.ode4_step(c, x, u),
        lambda t, x, u, params: laws.read_encoder(c, x),
        inputs=["t0", "t1"], outputs=["y0", "y1"], states=4, dt=c.dt, name="plant",
    )  # fmt: skip
    controller = control.nlsys(
        lambda t, x, u, params: laws.low_pass(c, laws.difference(u[:2], u[2:]), x),
        lambda t, x, u, params: laws.pd(c, laws.difference(u[:2], u[2:]), x),
        inputs=["r0", "r1", "y0", "y1"], outputs=["t0", "t1"], states=2, dt=c.dt, name="pd",
    )  # fmt: skip
    loop = control.interconnect(
        [plant, controller], inputs=["r0", "r1"], outputs=["y0", "y1", "t0", "t1"]
    )
    times = c.dt * np.arange(len(reference))

    def run() -> Signals:
        outputs = control.input_output_response(loop, times, reference.T).outputs
        return outputs[:2].T, outputs[2:].T

    return run


def pathsim(c: Constants, reference: NDArray[np.float64]) -> Run:
    """PathSim: a continuous plant under its fixed-step RK4 and a controller on a schedule."""
    from pathsim import Connection, Simulation
    from pathsim.blocks import ODE, Wrapper
    from pathsim.solvers import RK4

    measured, command = np.zeros(reference.shape), np.zeros(reference.shape)
    memory: dict[str, Any] = {}

    def control(*angles: float) -> list[float]:
        k = memory["k"]
        if k >= len(reference):  # the schedule fires at the end, too
            return [0.0, 0.0]
        measured[k] = read = laws.read_encoder(c, angles)
        error = laws.difference(reference[k], read)
        command[k] = torque = laws.pd(c, error, memory["low"])
        memory.update(k=k + 1, low=laws.low_pass(c, error, memory["low"]))
        return torque

    def slope(x: Any, u: Any, t: float) -> Any:
        return np.array([x[2], x[3], *laws.acceleration(c, x[2:], u)])

    def run() -> Signals:
        memory.update(k=0, low=[0.0, 0.0])
        plant, controller = ODE(slope, np.zeros(4)), Wrapper(control, T=c.dt)
        wires = [
            *(Connection(plant[j], controller[j]) for j in (0, 1)),
            *(Connection(controller[j], plant[j]) for j in (0, 1)),
        ]
        loop = Simulation([plant, controller], wires, dt=c.dt, Solver=RK4, log=False)
        loop.run(c.dt * len(reference), adaptive=False)
        return measured.copy(), command.copy()

    return run


def bdsim(c: Constants, reference: NDArray[np.float64]) -> Run:
    """bdsim: zero-order holds on one clock keep all states, function blocks compute the next ones."""
    import bdsim as engine

    simulator = engine.BDSim(
        sysargs=False, banner=False, graphics=False, progress=False, quiet=True, toolboxes=False
    )
    diagram = simulator.blockdiagram()
    clock = diagram.clock(c.dt, name="clock")
    last = len(reference) - 1

    def command(place: float, x: Any, low: Any) -> Any:
        """Measured angles, error and command, two each."""
        read = laws.read_encoder(c, x)
        error = laws.difference(reference[min(int(place), last)], read)
        return np.array([*read, *error, *laws.pd(c, error, low)])

    place, plant, low, note = (
        diagram.ZOH(clock, x0=x0, name=name)
        for name, x0 in (("k", 0.0), ("plant", [0.0] * 4), ("low", [0.0] * 2), ("note", [0.0] * 6))
    )
    controller = diagram.FUNCTION(command, nin=3)
    for j, state in enumerate((place, plant, low)):
        diagram.connect(state, controller[j])
    for state, law in (
        (plant, lambda y, x: np.array(laws.ode4_step(c, x, y[4:]))),
        (low, lambda y, x: np.array(laws.low_pass(c, y[2:4], x))),
        (place, lambda y, k: k + 1.0),
    ):
        block = diagram.FUNCTION(law, nin=2)
        diagram.connect(controller, block[0])
        diagram.connect(state, block[1])
        diagram.connect(block, state)
    diagram.connect(controller, note)
    diagram.connect(note, diagram.NULL())
    diagram.compile(report=False)

    def run() -> Signals:
        out = simulator.run(diagram, c.dt * (len(reference) + 0.5))
        notes = out.clock.X[:, -6:]
        return notes[:, :2], notes[:, 4:]

    return run

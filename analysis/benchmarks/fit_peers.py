"""Prediction errors of the C-drive's log by Drake and by MuJoCo, written out for two shafts, to be fitted.

The plant starts each sample where the last reading corrects it to and is moved on by one ODE4 step under the logged
command. Both simulators call back into Python for the friction, for they have no tanh law.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

UNBOUNDED = 1e6  # in scales of a parameter, where a bound of infinity is not taken

Floats = NDArray[np.float64]
Residual = Callable[["Numbers"], Floats]  # (samples, 2) [rad]


class Numbers(NamedTuple):
    """What a fit changes: SI units, elements in the order left motor, right motor, collar."""

    inverse: Sequence[Sequence[float]]  # of the inertia matrix (2, 2)
    viscous: Sequence[float]  # (3,)
    level: Sequence[float]  # of dry friction (3,)
    width: Sequence[float]  # of its smoothed sign (3,)


class Log(NamedTuple):
    """What is predicted, and the gains of the correction."""

    position: Floats  # (samples, 2) [rad]
    command: Floats  # (samples, 2) [N m]
    dt: float
    alpha: float  # on position [-]
    beta: float  # on speed [1/s]


def log_of(position: Floats, command: Floats, dt: float, bandwidth: float) -> Log:
    """The log with the gains of a double pole at ``bandwidth`` [rad/s]."""
    pole = math.exp(-bandwidth * dt)
    return Log(position, command, dt, 1.0 - pole * pole, (1.0 - pole) ** 2 / dt)


def drag(n: Numbers, left: float, right: float) -> tuple[float, float]:
    """Friction torques [N m] at both shafts from their speeds [rad/s]."""
    speeds = (left, right, left - right)
    a, b, c = (
        n.viscous[i] * v + n.level[i] * math.tanh(v / n.width[i]) for i, v in enumerate(speeds)
    )
    return a + c, b - c


def acceleration(n: Numbers, v: Sequence[float], torque: Sequence[float]) -> tuple[float, float]:
    """Accelerations [rad/s^2] of both shafts."""
    rub = drag(n, v[0], v[1])
    net = torque[0] - rub[0], torque[1] - rub[1]
    (a, b), (c, d) = n.inverse
    return a * net[0] + b * net[1], c * net[0] + d * net[1]


def ode4(n: Numbers, state: Sequence[float], torque: Sequence[float], h: float) -> list[float]:
    """State (4,), angles then speeds, one sample later."""
    v = state[2:]
    a1 = acceleration(n, v, torque)
    a2 = acceleration(n, [v[j] + 0.5 * h * a1[j] for j in (0, 1)], torque)
    a3 = acceleration(n, [v[j] + 0.5 * h * a2[j] for j in (0, 1)], torque)
    a4 = acceleration(n, [v[j] + h * a3[j] for j in (0, 1)], torque)
    angles = [state[j] + h * v[j] + h * h / 6 * (a1[j] + a2[j] + a3[j]) for j in (0, 1)]
    return angles + [v[j] + h / 6 * (a1[j] + 2 * a2[j] + 2 * a3[j] + a4[j]) for j in (0, 1)]


def by_drake(log: Log) -> Residual:
    """A Diagram of TrajectorySource, a plant with plain Python laws and a log, built once."""
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder, LeafSystem
    from pydrake.systems.primitives import TrajectorySource, VectorLogSink
    from pydrake.trajectories import PiecewisePolynomial

    start: Any = np.array([*log.position[0], 0.0, 0.0])

    class Predicted(LeafSystem):
        numbers: Numbers

        def __init__(self) -> None:
            super().__init__()
            self._logged: Any = self.DeclareVectorInputPort("logged", 4)
            self._state = self.DeclareDiscreteState(start)
            self.DeclareVectorOutputPort("error", 2, self._output)
            self.DeclarePeriodicDiscreteUpdateEvent(log.dt, 0.0, self._update)

        def _output(self, context: Any, output: Any) -> None:
            x = context.get_discrete_state(self._state).value()
            output.SetFromVector(self._logged.Eval(context)[:2] - x[:2])

        def _update(self, context: Any, state: Any) -> None:
            x = context.get_discrete_state(self._state).value()
            logged = self._logged.Eval(context)
            error = logged[:2] - x[:2]
            near = [*(x[:2] + log.alpha * error), *(x[2:] + log.beta * error)]
            after = ode4(self.numbers, near, logged[2:], log.dt)
            state.set_value(self._state, np.array(after))

    builder = DiagramBuilder()
    samples = len(log.position)
    values = np.hstack([log.position, log.command])
    breaks = log.dt * (np.arange(samples + 1) - 0.5)
    held = PiecewisePolynomial.ZeroOrderHold(breaks, np.vstack([values, values[-1:]]).T)
    source = builder.AddSystem(TrajectorySource(held))
    plant: Any = builder.AddSystem(Predicted())
    sink: Any = builder.AddSystem(VectorLogSink(2, publish_period=log.dt))
    builder.Connect(source.get_output_port(), plant.get_input_port())
    builder.Connect(plant.get_output_port(), sink.get_input_port())
    diagram = builder.Build()

    def residual(numbers: Numbers) -> Floats:
        plant.numbers = numbers
        simulator = Simulator(diagram)
        simulator.AdvanceTo(log.dt * (samples - 1))
        return np.array(sink.FindLog(simulator.get_context()).data().T)

    return residual


def by_mujoco(log: Log) -> Residual:
    """MuJoCo's RK4, its state corrected before every step. Raises ImportError where it is not installed."""
    from .other_peers import MODEL, mujoco_engine

    engine = mujoco_engine()
    to_joints = np.array([[1.0, 1.0], [1.0, -1.0]])  # sum and difference of the shafts

    def residual(numbers: Numbers) -> Floats:
        inertia = np.linalg.inv(np.array(numbers.inverse))
        both, gap = (float(0.5 * (inertia[0, 0] + s * inertia[0, 1])) for s in (1.0, -1.0))
        form = {"dt": repr(log.dt), "sum": repr(both), "gap": repr(gap)}
        model = engine.MjModel.from_xml_string(MODEL.format(**form))
        data = engine.MjData(model)

        def rub(model: Any, data: Any) -> None:
            both, gap = data.qvel
            left, right = drag(numbers, 0.5 * (both + gap), 0.5 * (both - gap))
            data.qfrc_passive[:] = (-0.5 * (left + right), -0.5 * (left - right))

        data.qpos[:] = to_joints @ log.position[0]
        error = np.empty_like(log.position)
        engine.set_mjcb_passive(rub)
        try:
            for k, (read, torque) in enumerate(zip(log.position, log.command)):
                error[k] = read - 0.5 * (to_joints @ data.qpos)
                off = to_joints @ error[k]
                data.qpos += log.alpha * off
                data.qvel += log.beta * off
                data.ctrl[:] = torque
                engine.mj_step(model, data)
        finally:
            engine.set_mjcb_passive(None)
        return error

    return residual


def sysid_fit(
    residual: Callable[[Floats], Floats], start: Floats, lower: Floats, upper: Floats, steps: int
) -> Floats:
    """Parameters that ``mujoco.sysid.optimize`` ends at. Raises ImportError where it is not installed."""
    import contextlib
    import io

    from mujoco import sysid

    if not hasattr(sysid, "optimize"):
        raise ImportError("mujoco.sysid lacks its own dependencies; pip install 'mujoco[sysid]'")

    def columns(x: Floats) -> Floats:
        """Residuals of one point (p,) or of points side by side (p, points), as its Jacobian asks for."""
        return np.column_stack([residual(point) for point in x.T]) if x.ndim == 2 else residual(x)

    parameters = sysid.ParameterDict()
    for i, (x, low, high) in enumerate(zip(start, lower, upper)):
        parameters.add(sysid.Parameter(f"x{i}", x, low, min(high, UNBOUNDED)))
    parameters.move_off_bounds()  # as it asks for: its steps shrink to nothing at a bound
    with contextlib.redirect_stdout(io.StringIO()):  # it prints every iteration
        _, found = sysid.optimize(
            parameters,
            lambda x, _: ([columns(np.asarray(x))], None, None),
            verbose=False,
            max_iters=steps,
        )
    return np.asarray(found.x, dtype=float).ravel()

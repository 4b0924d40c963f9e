"""A piezo stack in open loop behind the rig: ``system.kind: piezo_stack``.

The controller turns the length that is asked for into a voltage by the nominal gain, and nothing corrects it. It homes
where it stands, where the sensor's zero is set. Before every motion and every log the amplifier wipes the memory of the
ceramic by a decaying alternation about the present voltage, as one does in a laboratory: it ends at rest there.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...models import encoder, piezo_stack_kernel
from ...models.piezo_stack import DECADES, PiezoStack, linear_stack
from ..errors import InputError
from ..gap.machines.settings import Settings
from . import faults
from .machine import Axis, Floats, Layout, Trajectory
from .setpoints import out_and_back

DT = 0.005  # [s]
LSB, NOISE = 0.001, 0.003  # count and rms noise of the sensor [um]
MOST = 150.0  # of the amplifier [V]
NOMINAL = {"gain_um_per_V": 0.12, "offset_um": 0.0}
STROKES = {"short": 5.0, "medium": 9.0, "long": 14.0}  # [um]
ELEMENTS = np.array([12.0, 30.0, 55.0])  # limits of the hysteresis's stops [V]


class Plant:
    """What effects act on."""

    def __init__(self) -> None:
        self.stack: PiezoStack = linear_stack(
            NOMINAL["gain_um_per_V"], NOMINAL["offset_um"], 0.0
        )._replace(low=0.0, high=MOST)

    def change(self, **fields: Any) -> None:
        """Replace constants of the stack."""
        self.stack = self.stack._replace(**fields)


class Piezo:
    """The stack with a fault."""

    programs: Sequence[str] = tuple(STROKES)

    def __init__(self, fault: str = "none", seed: int = 0) -> None:
        self._nominal: dict[str, Any] = dict(NOMINAL)
        self._plant = Plant()
        self.answer = faults.give(fault, self._plant, FAULTS, seed)
        self.layout = _layout()
        self._decades = np.array(DECADES)
        self.power_up(np.random.default_rng(0))

    def power_up(self, rng: np.random.Generator) -> None:
        """No voltage, no memory."""
        self._rng, self._disturbed = rng, 0.0
        self._time = self._zero = self._voltage = 0.0
        self.wake()

    def read(self) -> Floats:
        """Sensor (1,) [um]."""
        return np.array([encoder.read(self._length - self._zero + self._disturbed, LSB)])

    def preset(self, motors: Floats) -> None:
        """Let the sensor read ``motors`` here, to whole counts."""
        self._zero = self._length - float(motors[0])

    def true_axes(self) -> Floats:
        """Where the stack really is (1,)."""
        return np.array([self._length])

    def wake(self) -> None:
        """At rest under the present voltage, which is stated with the run."""
        self._rest = self._voltage
        rested = self._plant.stack._replace(before=self._voltage)
        self._memory = piezo_stack_kernel.at_rest(rested, self._decades)
        self._advance(0.0)

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """Voltage (1,) for a length, to which the amplifier goes evenly over the sample."""
        asked = (reference[0] - self._nominal["offset_um"]) / self._nominal["gain_um_per_V"]
        self._voltage = float(np.clip(asked, 0.0, MOST))
        self._disturbed = NOISE * self._rng.standard_normal()
        self._advance(DT)
        return np.array([self._voltage])

    def _advance(self, h: float) -> None:
        self._time += h
        self._length = piezo_stack_kernel.advance(
            self._voltage, h, self._time, self._plant.stack, self._decades, *self._memory
        )

    def brake(self) -> None:
        """Hold the voltage."""

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": {"kind": "open_loop"}, "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Another nominal model; there is no loop."""
        if dict(controller) not in ({}, {"kind": "open_loop"}):
            raise InputError("configure, controller", f"{dict(controller)}", "kind: open_loop")
        new = {**self._nominal, **nominal}
        values = Settings("configure, nominal", new, set(NOMINAL))
        values.number("gain_um_per_V", positive=True)
        values.number("offset_um")
        self._nominal = new

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A stroke out and back."""
        strokes = {key: np.array([value]) for key, value in STROKES.items()}
        return out_and_back(name, strokes, rate, cycles, DT)

    def columns(self) -> dict[str, str]:
        """As in every log set of a piezo stack."""
        return {"t": "s", "u": "V", "y": "um"}

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, voltage, and the length where the voltage has arrived."""
        return [time, command[0], self.read()[0]]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        return {
            "system": {"kind": "piezo_stack", "nominal": {**self._nominal, "rest_V": self._rest}},
            "sample_time_s": DT,
            "controller": {"kind": "open_loop"},
        }


def _hysteretic(plant: Plant, share: float) -> None:
    plant.change(limits=ELEMENTS, shares=share * np.array([0.4, 0.3, 0.3]))


FAULTS = {
    fault.name: fault
    for fault in (
        faults.Fault(name="hysteresis", effect="actuator.hysteresis", apply=_hysteretic,
                     strength=(0.15, 0.3), unit="of the voltage, before its elements slip"),
        faults.Fault(name="lag", effect="actuator.lag",
                     apply=lambda plant, value: plant.change(lag=value),
                     strength=(0.01, 0.03), unit="s"),
        faults.Fault(name="weak", effect="actuator.torque_constant",
                     apply=lambda plant, value: plant.change(gain=value * plant.stack.gain),
                     strength=(0.8, 0.92), unit="-"),
    )
}  # fmt: skip


def _layout() -> Layout:
    return Layout(
        kind="piezo_stack",
        motors=("stack",),
        unit="um",
        effort="V",
        axes=(Axis(name="stack", unit="um", speed=8.0, acceleration=40.0, low=-0.5, high=17.0),),
        axis_map=np.ones((1, 1)),
        origin=np.zeros(1),
        home=np.zeros(1),
        finds_switch=False,
        lsb=LSB,
        following_error=6.0,
        dt=DT,
        rate=0.5,
    )

"""Nominal model of a pendulum on a position servo (``system.kind: pendulum``), such as an XL330.

The logged register of the firmware's PWM and the logged supply give the motor's voltage, which drives
the prediction; samples may be uneven. What the log set does not state of the servo is taken from its
makers, with a tolerance of its own: torque constant and resistance from the stall figures of the
XL330-M288-T (ROBOTIS e-manual: 0.52 N m and 1.47 A at 5 V), which include the gear's losses, and
the rotor's inertia from Duclusaud et al. 2025 (their parameters of the XL330, model M1).

Not tried on this machine: backlash and compliance of the gear, presliding, ripple, thermal drift, and
a scale error of the encoder, which reads an absolute angle.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ....models import drive_kernels, servo_pendulum, servo_pendulum_kernels
from ....models.servo_pendulum import GRAVITY, PWM_FULL_SCALE, ServoPendulum, ideal_servo
from ...errors import InputError
from .. import floor as floors
from ..description import FILE
from ..logset import LogSet, Run
from ..machine import Array, Machine, Parameter, RunData, encoder_step, own_parameter
from .hold_out import hold_back_runs
from .reference import uneven_derivatives
from .settings import (
    Settings,
    require_controllers,
    require_sizes,
    require_units,
    run_settings,
    tolerance,
)

if TYPE_CHECKING:
    from ..clock import ReplayCheck
    from ..effects import Form
    from ..signals import SignalFinding

TORQUE_CONSTANT = 0.52 / 1.47  # [N m/A]
RESISTANCE = 5.0 / 1.47  # [ohm]
ROTOR_INERTIA = 1.7e-3  # [kg m^2], from the output shaft
MOTOR_TOLERANCE = 0.3  # the published XL330 parameters differ from the data sheet by up to 28 %
ROTOR_TOLERANCE = 0.5  # of an inertia that somebody else's unit had
BANDWIDTH = 20.0  # of the prediction's correction [rad/s], about twice the pendulum's own frequency
SUBSTEPS = 3  # integration steps per sample of the prediction
FIRMWARE_STEPS = 5  # of the closed loop, about the firmware's millisecond
WRAP = 1 << 16  # of a register that counts negative values down from here


@dataclass(frozen=True, kw_only=True)
class Firmware:
    """The servo's own position control: P gain in firmware units on a supply voltage."""

    gain: float
    supply: float  # [V]
    stall_torque: float  # at nominal constants, per volt [N m/V]

    def replay(self, run: RunData) -> Array:
        """Command (samples, 1) [N m at standstill] for the logged reference and position."""
        assert isinstance(run, ServoRun)
        voltage = run.connected * self.voltage((run.reference - run.position)[:, 0])
        return np.asarray(self.stall_torque * voltage[:, None])

    def voltage(self, error: Array) -> Array:
        """Voltage (samples,) [V] at position errors (samples,) [rad]."""
        return np.array([self.supply * servo_pendulum.duty(e, self.gain) for e in error])


@dataclass(frozen=True, kw_only=True)
class ServoRun(RunData):
    """A run with what drives the servo; ``command`` is its torque at standstill, nominally [N m]."""

    voltage: Array  # (samples,) [V]
    arriving: Array  # (samples,) what it becomes until the next sample [V]
    connected: Array  # (samples,) 1 where the motor is switched on, else 0


@dataclass
class ServoPlant:
    """The servo that effects act on."""

    mass: float  # [kg]
    length: float  # [m]
    rotor: float  # inertia of the rotor [kg m^2]
    servo: ServoPendulum
    time: float = 0.0

    def change(self, **fields: float) -> None:
        """Replace constants of the servo."""
        self.servo = self.servo._replace(**fields)

    def finished(self) -> ServoPendulum:
        """The servo with the inertia and weight of its load."""
        return self.servo._replace(
            inertia=self.mass * self.length**2 + self.rotor,
            gravity=self.mass * GRAVITY * self.length,
        )


@dataclass(frozen=True, kw_only=True)
class PendulumMachine(Machine):
    """A pendulum on a servo, predicted by its logged voltage."""

    # The motion tells torques only relative to each other: the load is the known one that the motor's
    # constants are measured by, so that its tolerance is part of theirs.
    mass: float  # [kg]
    length: float  # [m]

    def build(self, values: Mapping[str, float]) -> ServoPlant:
        """A servo without friction at the own parameters' values."""
        return ServoPlant(
            mass=self.mass,
            length=self.length,
            rotor=values["rotor_inertia"],
            servo=ideal_servo(0.0, 0.0, values["torque_constant"], values["resistance"]),
        )

    def predict(self, run: RunData, plant: ServoPendulum) -> Array:
        """Prediction error (samples, 1) of the encoder over the run's window [rad]."""
        assert isinstance(run, ServoRun)
        residual = np.empty(len(run.t))
        servo_pendulum_kernels.predict(
            run.t, run.position[:, 0], run.voltage, run.arriving, run.connected, plant,
            SUBSTEPS, BANDWIDTH, residual,
        )  # fmt: skip
        return residual[run.window][:, None]

    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """Friction of the gear, flaws of the drive, errors of load and encoder."""
        from .pendulum_forms import pendulum_forms  # the effects' base names other machines

        return pendulum_forms(self.joints, runs)

    def unexplained(self, residual: Array, run: RunData) -> Array:
        """Torque (k, 1) [N m] that would cause a prediction error (k, 1) in steady state."""
        servo = self.build(self.nominal()).finished()
        _, on_rate = drive_kernels.correction_gains(BANDWIDTH, run.dt)
        return np.asarray(residual * servo.inertia * (on_rate / run.dt))

    def floor(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> tuple[list[Array], str]:
        """What the encoder's resolution does; cycle-to-cycle repeatability where motions repeat."""
        return floors.noise_floor(runs, residuals, BANDWIDTH)

    def examine(
        self, runs: Sequence[RunData], stated_step: float | None
    ) -> "tuple[list[RunData], list[SignalFinding]]":
        """Wrong signals are found by replaying the firmware's law."""
        from ..signals import examine

        return examine(self, runs, stated_step)

    def replays(self, runs: Sequence[RunData]) -> "list[ReplayCheck]":
        """Every run's logged command beside the firmware's law."""
        from ..clock import check_replay

        return [check_replay(run) for run in runs]

    def simulate(self, run: RunData, plant: ServoPendulum) -> tuple[Array, Array]:
        """Position [rad] and command [N m at standstill] (samples, 1) of the firmware's loop."""
        assert isinstance(run, ServoRun)
        firmware = run.controller
        position, voltage = np.empty(len(run.t)), np.empty(len(run.t))
        position[0] = run.position[0, 0]
        servo_pendulum_kernels.simulate(
            run.t, run.reference[:, 0], firmware.supply, firmware.gain, run.connected, plant,
            FIRMWARE_STEPS, position, voltage,
        )  # fmt: skip
        return position[:, None], firmware.stall_torque * voltage[:, None]


def read(logset: LogSet) -> tuple[Machine, list[RunData]]:
    """Machine and runs of a pendulum log set; every fourth run is held back if none is marked."""
    require_units(logset, {"q_ref": "rad", "q": "rad", "volts": "V"})
    for name in ("load_raw", "torque_enable"):
        if name not in logset.units:
            raise InputError(
                f"{logset.folder / FILE}, columns.{name}", "no such column",
                "the firmware's PWM register and whether the motor is switched on, 0 or 1",
            )  # fmt: skip
        require_sizes(logset, name)
    machine = _machine(logset)
    require_controllers(logset, "servo_position")
    return machine, hold_back_runs([_run(run, logset, machine) for run in logset.runs])


def _machine(logset: LogSet) -> PendulumMachine:
    system = Settings(
        f"{logset.folder / FILE}, system",
        logset.system,
        {"kind", "note", "description", "tolerance", "limits", "mass_kg", "length_m",
         "torque_constant_Nm_per_A", "resistance_ohm", "rotor_inertia_kg_m2"},
    )  # fmt: skip
    relative = tolerance(logset)

    def motor(name: str, key: str, unit: str, otherwise: float, loose: float) -> Parameter:
        stated = relative if key in logset.system else loose
        return own_parameter(name, unit, system.number(key, otherwise, positive=True), stated)

    return PendulumMachine(
        kind="pendulum",
        joints=("pendulum",),
        position_unit="rad",
        effort_unit="N m",
        mass=system.number("mass_kg", positive=True),
        length=system.number("length_m", positive=True),
        own=(
            motor("torque_constant", "torque_constant_Nm_per_A", "N m/A", TORQUE_CONSTANT,
                  MOTOR_TOLERANCE),
            motor("resistance", "resistance_ohm", "ohm", RESISTANCE, MOTOR_TOLERANCE),
            motor("rotor_inertia", "rotor_inertia_kg_m2", "kg m^2", ROTOR_INERTIA,
                  ROTOR_TOLERANCE),
        ),
    )  # fmt: skip


def _run(run: Run, logset: LogSet, machine: PendulumMachine) -> ServoRun:
    settings = run_settings(logset, run, "kp")
    nominal = machine.nominal()
    firmware = Firmware(
        gain=settings.number("kp", positive=True),
        # The supply's reading picks up the switching of the bridge; the median does not.
        supply=float(np.median(run.columns["volts"])),
        stall_torque=nominal["torque_constant"] / nominal["resistance"],
    )
    register = run.columns["load_raw"]
    signed = np.where(register >= WRAP // 2, register - WRAP, register)
    if np.max(np.abs(signed)) > PWM_FULL_SCALE:
        raise InputError(
            f"{run.name}, column load_raw",
            f"a register of {np.max(np.abs(signed)):g}",
            f"at most {PWM_FULL_SCALE}, the full scale of the PWM",
        )
    connected = np.where(run.columns["torque_enable"] > 0.5, 1.0, 0.0)
    voltage = connected * firmware.supply * signed / PWM_FULL_SCALE
    position, reference = run.stack("q"), run.stack("q_ref")
    following = np.append(position[1:, 0], position[-1, 0])
    arriving = connected * firmware.voltage(reference[:, 0] - following)
    rate, acceleration = uneven_derivatives(reference, run.columns["t"])
    return ServoRun(
        name=run.name,
        use=run.use,
        settings=run.settings,
        dt=float(np.median(np.diff(run.columns["t"]))),
        t=run.columns["t"],
        reference=reference,
        reference_rate=rate,
        reference_acceleration=acceleration,
        position=position,
        command=firmware.stall_torque * voltage[:, None],
        controller=firmware,
        period=None if logset.uneven else settings.period(logset.dt),
        lsb=encoder_step(position),
        start=settings.start,
        voltage=voltage,
        arriving=arriving,
        connected=connected,
    )

"""Forms of the catalogue's effects on a PepperMill-Carrier.

What acts at motors and encoders is that of every machine with shafts. Here is what its limbs, gripper and counterweight
add. A length of the screws or the spacing of the drives leaves no trace in motor angles; flexible links and the bearings'
compliance do only where they are soft enough to swing.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

from ....models.drive import COUPLING_DAMPING, COUPLING_STIFFNESS, GAP
from . import (
    actuator_delay,
    actuator_lag,
    actuator_ripple,
    actuator_saturation,
    actuator_torque_constant,
    dry_friction,
    friction_coulomb,
    friction_load_dependent,
    friction_presliding,
    friction_stribeck,
    friction_thermal_drift,
    friction_viscous,
    load_bias,
    sensor_scale,
)
from .base import RARE, Form, Scales, Values, at, everywhere, parameter

if TYPE_CHECKING:
    from ..carrier_machine import CarrierMachine, CarrierPlant

OF_SHAFTS = (
    friction_viscous,
    friction_coulomb,
    friction_stribeck,
    friction_presliding,
    friction_load_dependent,
    friction_thermal_drift,
    actuator_delay,
    actuator_lag,
    actuator_saturation,
    actuator_torque_constant,
    actuator_ripple,
    load_bias,
    sensor_scale,
)
PASSIVE = ("elbow", "wrist")
LIMBS = ("theta1", "theta2")
OFFSET_UNITS = {"d1": "m", "d2": "m", "theta1": "rad", "theta2": "rad"}
STEPS_PER_RADIAN = 1.2  # Runge-Kutta steps per radian of the coupling's own mode
MOST_SUBSTEPS = 12


def forms(machine: "CarrierMachine", scales: Scales) -> list[Form]:
    """Every form that can act on the robot."""
    shared = [form for module in OF_SHAFTS for form in module.forms(machine, scales)]
    own = [
        _passive_viscous(),
        _passive_dry(machine, scales),
        _pulley_dry(machine),
        _payload(),
        _counterweight(),
        _geometry(),
        _offset(),
        _link_compliance(machine, scales),
        _clearance(machine, scales),
    ]
    return shared + own


def _passive_viscous() -> Form:
    free = tuple(parameter(f"viscous_{j}", "N m s/rad", 0.1, lower=-0.1) for j in PASSIVE)

    def apply(plant: "CarrierPlant", values: Values) -> None:
        c = plant.robot.constants
        _change(
            plant,
            elbow_damping=c.elbow_damping + values.get("viscous_elbow", 0.0),
            wrist_damping=c.wrist_damping + values.get("viscous_wrist", 0.0),
        )

    return Form(
        effect="friction.viscous",
        name="elbows and wrists",
        parameters=free,
        apply=apply,
        where=at("joints", "viscous_"),
        removable=frozenset(p.name for p in free),
        takes={f"viscous_{j}": f"{j}_damping" for j in PASSIVE},
        own_start=True,
    )


def _passive_dry(machine: "CarrierMachine", scales: Scales) -> Form:
    free = tuple(parameter(f"level_{j}", "N m", scales.effort, lower=0.0) for j in PASSIVE)
    # Their rates are those of the drive angles, a hundredth of the motors' fastest.
    width = parameter("width", "rad/s", 0.01, lower=1e-4, upper=0.2, starts=(0.02,))

    def apply(plant: "CarrierPlant", values: Values) -> None:
        levels = [values.get(f"level_{j}", 0.0) for j in PASSIVE]
        plant.robot = plant.robot._replace(passive_dry=np.array([*levels, values["width"]]))

    return Form(
        effect="friction.coulomb",
        name="elbows and wrists",
        parameters=(*free, width),
        apply=apply,
        where=at("joints", "level_"),
        shapes=frozenset({"width"}),
        removable=frozenset(p.name for p in free),
        family=dry_friction.FAMILY,
        own_start=True,
    )


def _pulley_dry(machine: "CarrierMachine") -> Form:
    level = parameter("level_pulley", "N", 2.0, lower=0.0)
    width = parameter("width", "m/s", 2e-3, lower=1e-4, upper=0.05,
                      starts=(machine.parameters.counterweight.friction_speed,))  # fmt: skip

    def apply(plant: "CarrierPlant", values: Values) -> None:
        c = plant.robot.constants
        _change(
            plant,
            rope_friction=c.rope_friction + values.get("level_pulley", 0.0),
            rope_friction_speed=values["width"],
        )

    return Form(
        effect="friction.coulomb",
        name="pulley of the counterweight",
        parameters=(level, width),
        apply=apply,
        where=everywhere("bodies", ("pulley",)),
        shapes=frozenset({"width"}),
        family=dry_friction.FAMILY,
        own_start=True,
    )


def _payload() -> Form:
    free = (
        parameter("extra_mass", "kg", 0.5),
        parameter("extra_inertia", "kg m^2", 1e-3, lower=-2e-4),
    )

    def apply(plant: "CarrierPlant", values: Values) -> None:
        c = plant.robot.constants
        _change(
            plant,
            mill_mass=c.mill_mass + values.get("extra_mass", 0.0),
            mill_inertia=c.mill_inertia + values.get("extra_inertia", 0.0),
        )

    return Form(
        effect="inertia.payload",
        name="on the gripper",
        parameters=free,
        apply=apply,
        where=everywhere("bodies", ("pepper_mill",)),
        removable=frozenset(p.name for p in free),
        replaces=frozenset({"pepper_mill_mass"}),
    )


def _counterweight() -> Form:
    def apply(plant: "CarrierPlant", values: Values) -> None:
        c, extra = plant.robot.constants, values["extra_counterweight"]
        _change(
            plant,
            rope_mass=c.rope_mass + extra,
            rope_weight=c.rope_weight + extra * c.gravity,
        )

    return Form(
        effect="load.bias",
        name="counterweight",
        parameters=(parameter("extra_counterweight", "kg", 0.5),),
        apply=apply,
        where=everywhere("bodies", ("counterweight",)),
        replaces=frozenset({"counterweight"}),
        own_start=True,
    )


def _geometry() -> Form:
    free = tuple(
        parameter(f"extra_{length}", "m", 0.01, lower=-0.03, upper=0.03)
        for length in ("proximal", "distal")
    )

    def apply(plant: "CarrierPlant", values: Values) -> None:
        d = plant.robot.constants.dimensions
        dimensions = d._replace(
            proximal=d.proximal + values.get("extra_proximal", 0.0),
            distal=d.distal + values.get("extra_distal", 0.0),
        )
        _change(plant, dimensions=dimensions)

    return Form(
        effect="geometry.parameter",
        name="link lengths",
        parameters=free,
        apply=apply,
        where=at("lengths", "extra_"),
        removable=frozenset(p.name for p in free),
    )


def _offset() -> Form:
    free = tuple(
        parameter(f"offset_{joint}", unit, 0.01, lower=-0.1, upper=0.1)
        for joint, unit in OFFSET_UNITS.items()
    )

    def apply(plant: "CarrierPlant", values: Values) -> None:
        offset = [values.get(f"offset_{joint}", 0.0) for joint in OFFSET_UNITS]
        plant.robot = plant.robot._replace(home=plant.robot.home + np.array(offset))

    return Form(
        effect="sensor.offset",
        name="home of the encoders",
        parameters=free,
        apply=apply,
        where=at("joints", "offset_"),
        removable=frozenset(p.name for p in free),
    )


def _link_compliance(machine: "CarrierMachine", scales: Scales) -> Form:
    stiffness = parameter("log_stiffness", "ln(N m/rad)", 1.0, lower=np.log(50.0), upper=np.log(2e4),
                          starts=tuple(np.log([1e4, 2500.0, 600.0, 150.0])))  # fmt: skip
    damping = parameter("damping_ratio", "-", 0.1, lower=0.0, upper=1.0, starts=(0.1,))

    def apply(plant: "CarrierPlant", values: Values) -> None:
        k = float(np.exp(values["log_stiffness"]))
        _couple(plant, machine, scales, k, values["damping_ratio"], gap=0.0)

    return Form(
        effect="transmission.compliance",
        name="links bend at the drives",
        parameters=(stiffness, damping),
        apply=apply,
        where=everywhere("joints", LIMBS),
        family="two inertias",
    )


def _clearance(machine: "CarrierMachine", scales: Scales) -> Form:
    gap = parameter("gap", "rad", 5e-3, lower=0.0, upper=0.1, starts=(1e-3, 5e-3, 2e-2))
    damping = parameter("contact_damping_ratio", "-", 0.5, lower=0.02, upper=3.0, starts=(0.5,))

    def apply(plant: "CarrierPlant", values: Values) -> None:
        _couple(plant, machine, scales, 5e3, values["contact_damping_ratio"], gap=values["gap"])

    return Form(
        effect="transmission.backlash",
        name="clearance between drive and link",
        parameters=(gap, damping),
        apply=apply,
        where=everywhere("joints", LIMBS),
        family="two inertias",
        step=0.02,
        own_start=True,
        price=RARE,
    )


def _couple(
    plant: "CarrierPlant",
    machine: "CarrierMachine",
    scales: Scales,
    stiffness: float,
    ratio: float,
    gap: float,
) -> None:
    """Let both drive sides turn on their own behind a coupling; the links lose what is theirs."""
    own = plant.robot.drive_inertia
    fastest = np.sqrt(stiffness / own)
    coupling = np.zeros((2, 5))
    coupling[:, COUPLING_STIFFNESS] = stiffness
    coupling[:, COUPLING_DAMPING] = 2.0 * ratio * stiffness / fastest
    coupling[:, GAP] = gap
    plant.drive = plant.drive._replace(coupling=coupling)
    c = plant.robot.constants
    _change(plant, crank_inertia=c.crank_inertia - own)
    wanted = int(np.ceil(fastest * scales.dt * STEPS_PER_RADIAN))
    plant.substeps = max(plant.substeps, min(wanted, MOST_SUBSTEPS))


def _change(plant: "CarrierPlant", **fields: Any) -> None:
    plant.robot = plant.robot._replace(constants=plant.robot.constants._replace(**fields))

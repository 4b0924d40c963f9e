"""Logs of a 2-PRR, a RePlaLink and a compliant 3-PRS from Drake's multibody trees, held together by their closures.

Bodies, springs and closures act on the coordinates of the tree; nothing of the machines' own equations is used. One
evaluation of the tree a sample, at its middle; dry friction of the axes in twenty steps of it. Encoders are quantised.
"""

from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np
import yaml
from pydrake.math import RollPitchYaw, RotationMatrix

from gapscope.models.parallel import chains, replalink, three_prs, two_prr
from gapscope.systems.closed_chain import ClosedChain

DT, SUBSTEPS, WIDTH = 1e-3, 20, 1.0  # [s], -, of the smoothed sign [rad/s]


@dataclass
class Rig:
    """A machine with its axes as they are; ``stated`` is what the log set says."""

    kind: str
    chain: object
    middle: np.ndarray
    size: float  # of the motion [m or rad]
    rotor: float
    gear: float
    lead: float | None  # of a guide [m/rev]; none for a crank
    constant: float
    viscous: float
    coulomb: tuple
    count: float  # of the motor's encoder [rad]
    stated: dict
    stiffness: tuple = ()  # of hinges, of spherical flexures in bending and torsion [N m/rad]

    @property
    def per_motor(self):
        return 1.0 / self.gear if self.lead is None else self.lead / (2.0 * np.pi * self.gear)


def two_prr_rig(payload=0.0, coulomb=(0.035, 0.035)):
    """Axes of section 6.1: gear 14:1, 70 mm a turn, friction of (6.23)-(6.26) at the motor."""
    printed = two_prr.TwoPRR()
    sliders = (0.6, 0.5)
    masses = (*sliders, *printed.masses[2:5], printed.masses[5] + payload)
    rotor, viscous = 1.56e-5, 3.0e-6
    stated = {
        "mass1_kg": sliders[0], "mass2_kg": sliders[1], "gear_ratio": 14.0, "lead_m_per_rev": 0.07,
        "torque_constant_Nm_per_A": 0.0302, "rotor_inertia_kg_m2": rotor,
        "viscous_Nms_per_rad": viscous, "coulomb_Nm": 0.035, "sign_width_rad_per_s": WIDTH,
    }  # fmt: skip
    return Rig(
        "two_prr", chains.two_prr(replace(printed, masses=masses)), np.array([0.2, 0.25]), 0.02,
        rotor, 14.0, 0.07, 0.0302, viscous, coulomb, 2.0 * np.pi / 2000, stated,
    )  # fmt: skip


def replalink_rig(coulomb=(0.0551, 0.0551)):
    """Gear 10:1, torque constant, rotors and mean friction of section 6.2; its rotors turn with the motors."""
    linkage = replace(replalink.REPLALINK, rotors=(0.0, 0.0))
    middle = (2.0944, 1.0472)
    rotor, viscous = 4.1e-5, 0.0367
    stated = {
        "gear_ratio": 10.0, "torque_constant_Nm_per_A": 1.08, "rotor_inertia_kg_m2": rotor,
        "viscous_Nms_per_rad": viscous, "coulomb_Nm": 0.0551, "sign_width_rad_per_s": WIDTH,
    }  # fmt: skip
    return Rig(
        "replalink", chains.five_bar(linkage, home=middle), np.array(middle), 0.2, rotor, 10.0, None,
        1.08, viscous, coulomb, 2.0 * np.pi / 2**13, stated,
    )  # fmt: skip


def three_prs_rig(payload=0.0, coulomb=(0.004, 0.004, 0.004)):
    """Screws of 2 mm a turn, assumed; flexures and bodies are those of the article. The load is a point."""
    printed = three_prs.THREE_PRS
    table = replace(printed, platform_mass=printed.platform_mass + payload)
    rotor, viscous = 2.0e-6, 1.0e-6
    stated = {
        "gear_ratio": 1.0, "lead_m_per_rev": 0.002, "torque_constant_Nm_per_A": 0.02,
        "rotor_inertia_kg_m2": rotor, "viscous_Nms_per_rad": viscous, "coulomb_Nm": 0.004,
        "sign_width_rad_per_s": WIDTH,
    }  # fmt: skip
    return Rig(
        "three_prs", chains.three_prs(table), np.zeros(3), 0.0008, rotor, 1.0, 0.002, 0.02, viscous,
        coulomb, 2.0 * np.pi / 2**14, stated, (98.37, 32.67, 24.46),
    )  # fmt: skip


def spring_force(rig, plant):
    """Force (n,) of the flexures over driven positions: a polynomial through energies of closed postures."""
    n, reach = len(rig.middle), 1.5 * rig.size
    if not rig.stiffness:
        return lambda q: np.zeros(n)
    rng = np.random.default_rng(0)
    terms = [t for d in range(6) for t in combinations_with_replacement(range(n), d)]
    places = rng.uniform(-1.0, 1.0, (4 * len(terms), n))
    home = rotations(plant, plant.close(rig.middle))
    energy = [
        spring_energy(rig, home, rotations(plant, plant.close(rig.middle + reach * p)))
        for p in places
    ]
    rows = np.array([[np.prod(p[list(t)]) for t in terms] for p in places])
    share, *_ = np.linalg.lstsq(rows, np.array(energy), rcond=None)

    def force(q):
        p = (q - rig.middle) / reach
        slope = np.zeros(n)
        for weight, t in zip(share, terms):
            for j in range(len(t)):
                slope[t[j]] += weight * np.prod(p[list(t[:j] + t[j + 1 :])])
        return slope / reach

    return force


def rotations(plant, coordinates):
    """Rotations of the links in the world, and bar slopes (3,) [rad]."""
    plant.plant.SetPositions(plant.context, coordinates)
    names = ("bar1", "bar2", "bar3", "platform")
    turned = {
        name: plant.plant.GetFrameByName(name).CalcPoseInWorld(plant.context).rotation().matrix()
        for name in names
    }
    slopes = [plant.plant.GetJointByName(name).get_angle(plant.context) for name in names[:3]]
    return turned, np.array(slopes)


def spring_energy(rig, home, now):
    """Of three hinges and three spherical flexures, by angles about m, n and the bar [J]."""
    hinge, bending, torsion = rig.stiffness
    (start, level), (turned, slopes) = home, now
    energy = 0.5 * hinge * np.sum((slopes - level) ** 2)
    for link in (rig.chain.links[k] for k in (1, 4, 6)):
        bar = start[link.name] @ -np.array(link.centre)
        frame = np.column_stack([-np.array(link.axis), np.zeros(3), -bar / np.linalg.norm(bar)])
        frame[:, 1] = np.cross(frame[:, 2], frame[:, 0])
        of_bar = turned[link.name] @ start[link.name].T
        of_platform = turned["platform"] @ start["platform"].T
        relative = frame.T @ of_bar.T @ of_platform @ frame
        angles = RollPitchYaw(RotationMatrix(relative.T)).vector()
        energy += 0.5 * (bending * np.sum(angles[:2] ** 2) + torsion * angles[2] ** 2)
    return energy


def run(rig, rate_hz, samples, seed):
    """Columns t, references, positions (n) [m or rad] and currents (n) [A]."""
    rng = np.random.default_rng(seed)
    plant, per, n = ClosedChain(rig.chain), rig.per_motor, len(rig.middle)
    springs = spring_force(rig, plant)
    t = DT * np.arange(samples)
    size, phase = rng.uniform(0.5, 1.0, (2, n)), rng.uniform(0.0, 2.0 * np.pi, n)
    w = 2.0 * np.pi * rate_hz * t[:, None]
    wave = size[0] * (np.cos(w + phase) - np.cos(phase)) + 0.3 * size[1] * (np.cos(2.0 * w) - 1.0)
    reference = rig.middle + 0.5 * rig.size * wave
    slope = np.gradient(reference, DT, axis=0) / per
    q, v, a = reference[0] / per, np.zeros(n), np.zeros(n)
    near, dry = plant.close(reference[0]), np.array(rig.coulomb)
    at = plant.project(near, v)
    hold = per * (at.bias + springs(per * q))
    position, current, before = np.empty((samples, n)), np.empty((samples, n)), q.copy()
    inertia = rig.rotor + per**2 * at.matrix[0, 0]
    for k in range(samples):
        seen = rig.count * np.round(q / rig.count)
        position[k] = per * seen
        error, speed = reference[k] / per - seen, slope[k] - (seen - before) / DT
        before = seen
        torque = hold + inertia * (200.0**2 * error + 250.0 * speed)
        current[k] = torque / rig.constant
        middle = q + 0.5 * DT * v + 0.125 * DT**2 * a
        near = plant.close(per * middle, near)
        at = plant.project(near, per * (v + 0.5 * DT * a))
        inverse = np.linalg.inv(rig.rotor * np.eye(n) + per**2 * at.matrix)
        load = per * (at.bias + springs(per * middle))
        h, start = DT / SUBSTEPS, v.copy()
        for _ in range(SUBSTEPS):
            lost = rig.viscous * v + dry * np.tanh(v / WIDTH)
            ahead = v + 0.5 * h * inverse @ (torque - load - lost)
            lost = rig.viscous * ahead + dry * np.tanh(ahead / WIDTH)
            v = v + h * inverse @ (torque - load - lost)
            q = q + h * ahead
        a = (v - start) / DT
    return np.column_stack([t, reference, position, current])


def write_log_set(folder, rig, samples=1000, seed=0):
    """Two runs to fit to and one to validate on."""
    folder.mkdir(parents=True, exist_ok=True)
    numbers = range(1, len(rig.middle) + 1)
    places = [f"q{i}_ref" for i in numbers] + [f"q{i}" for i in numbers]
    currents = [f"current{i}" for i in numbers]
    entries = []
    for i, (rate_hz, use) in enumerate(((2.0, "fit"), (3.0, "fit"), (2.5, "validate"))):
        name = f"run{i + 1}.csv"
        np.savetxt(
            folder / name, run(rig, rate_hz, samples, seed + i), delimiter=",", comments="",
            fmt="%.12f", header=",".join(["t", *places, *currents]),
        )  # fmt: skip
        entries.append({"file": name, "rate_Hz": rate_hz, "use": use, "controller": "pd"})
    document = {
        "format": 1,
        "name": rig.kind,
        "system": {"kind": rig.kind, "nominal": rig.stated},
        "controllers": {"pd": {"kind": "not stated"}},
        "sample_time_s": DT,
        "columns": {
            "t": "s",
            **dict.fromkeys(places, "rad" if rig.lead is None else "m"),
            **dict.fromkeys(currents, "A"),
        },
        "runs": entries,
    }
    (folder / "logset.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    return folder

"""A five-bar that shares no code with the instrument: two open arms held together by Lagrange multipliers.

Absolute link angles, closure solved for its forces at every stage, classical Runge-Kutta at the sample time, dry
friction by (4.10) of Roldan. A joint PD law drives it; encoders on the motors are quantised.
"""

from dataclasses import dataclass

import numpy as np
import yaml

GEAR, CONSTANT, ROTOR, VISCOUS, COULOMB = 40.0, 1.43, 13e-4, 1.7e-3, 0.478
H, L1, L2, L3, L4, TOOL = 0.2, 0.6, 0.7, 0.7, 0.6, 0.7
MASS, INERTIA = (0.49, 0.57, 0.57, 0.49, 0.5), (0.0147, 0.0233, 0.0233, 0.0147)
COUNT = 2.0 * np.pi / 2**14  # of a motor's encoder [rad]
WIDTH = 0.3  # of the smoothed sign [rad/s]
DT, CYCLES = 1e-3, 3


@dataclass
class Truth:
    tool_mass: float = MASS[4]
    rotor: float = ROTOR
    coulomb: tuple[float, float] = (COULOMB, COULOMB)  # of each motor [N m]
    gain: float = 1.0  # torque per torque commanded
    delay: int = 0  # samples


def acceleration(angle, rate, torque, truth):
    """Accelerations of crank 1, rod 2, rod 3, crank 4 under joint torques."""
    m1, m2, m3, m4, _ = MASS
    mt = truth.tool_mass
    rotor = truth.rotor * GEAR**2
    p2, p3 = m2 * L2 / 2 + mt * TOOL, m3 * L3 / 2
    c12, s12 = np.cos(angle[0] - angle[1]), np.sin(angle[0] - angle[1])
    c43, s43 = np.cos(angle[3] - angle[2]), np.sin(angle[3] - angle[2])
    matrix = np.zeros((6, 6))
    matrix[0, 0] = INERTIA[0] + m1 * L1**2 / 4 + (m2 + mt) * L1**2 + rotor
    matrix[1, 1] = INERTIA[1] + m2 * L2**2 / 4 + mt * TOOL**2
    matrix[2, 2] = INERTIA[2] + m3 * L3**2 / 4
    matrix[3, 3] = INERTIA[3] + m4 * L4**2 / 4 + m3 * L4**2 + rotor
    matrix[0, 1] = matrix[1, 0] = p2 * L1 * c12
    matrix[3, 2] = matrix[2, 3] = p3 * L4 * c43
    force = np.array(
        [
            torque[0] - p2 * L1 * s12 * rate[1] ** 2,
            p2 * L1 * s12 * rate[0] ** 2,
            p3 * L4 * s43 * rate[3] ** 2,
            torque[1] - p3 * L4 * s43 * rate[2] ** 2,
        ]
    )
    length = np.array([L1, L2, -L3, -L4])
    closure = length * np.array([-np.sin(angle), np.cos(angle)])
    matrix[4:, :4], matrix[:4, 4:] = closure, closure.T
    pull = length * np.array([np.cos(angle), np.sin(angle)]) @ np.diag(rate**2)
    return np.linalg.solve(matrix, np.concatenate([force, pull.sum(axis=1)]))[:4]


def rods(cranks):
    """Angles of the rods that close the loop, joint on the far side."""
    a = np.array([L1 * np.cos(cranks[0]) - H / 2, L1 * np.sin(cranks[0])])
    b = np.array([L4 * np.cos(cranks[1]) + H / 2, L4 * np.sin(cranks[1])])
    gap = b - a
    lift = np.sqrt(L2**2 - gap @ gap / 4)
    c = (a + b) / 2 + lift * np.array([-gap[1], gap[0]]) / np.linalg.norm(gap)
    return [np.arctan2(*(c - p)[::-1]) for p in (a, b)]


def run(truth, rate_hz, seed):
    """Columns t, references, positions (n, 2) [rad] and currents (n, 2) [A] of one run."""
    rng = np.random.default_rng(seed)
    n = round(CYCLES / rate_hz / DT)
    t = DT * np.arange(n)
    w = 2 * np.pi * rate_hz * t
    size, phase = rng.uniform(0.12, 0.2, (2, 2)), rng.uniform(0, 2 * np.pi, 2)
    waves = np.stack(
        [size[0, i] * (np.cos(w + phase[i]) - np.cos(phase[i]))
         + size[1, i] / 2 * (np.cos(2 * w) - 1) for i in range(2)], axis=1,
    )  # fmt: skip
    reference = np.array([2.2, 0.9]) + waves
    slope = np.gradient(reference, DT, axis=0)
    angle = np.array([reference[0, 0], *rods(reference[0]), reference[0, 1]])
    rates = np.zeros(4)
    position, current = np.empty((n, 2)), np.empty((n, 2))
    before = reference[0].copy()
    for k in range(n):
        position[k] = COUNT / GEAR * np.round(angle[[0, 3]] * GEAR / COUNT)
        speed = (position[k] - before) / DT
        before = position[k].copy()
        torque = 3000.0 * (reference[k] - position[k]) + 120.0 * (slope[k] - speed)
        current[k] = torque / GEAR / CONSTANT
        held = truth.gain * CONSTANT * current[max(k - truth.delay, 0)]

        def rate_of(x, held=held):
            motor = x[[4, 7]] * GEAR
            lost = VISCOUS * motor + np.array(truth.coulomb) * np.tanh(motor / WIDTH)
            return np.concatenate([x[4:], acceleration(x[:4], x[4:], GEAR * (held - lost), truth)])

        x = np.concatenate([angle, rates])
        k1 = rate_of(x)
        k2 = rate_of(x + DT / 2 * k1)
        k3 = rate_of(x + DT / 2 * k2)
        k4 = rate_of(x + DT * k3)
        x = x + DT / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        angle, rates = x[:4], x[4:]
    return np.column_stack([t, reference, position, current])


def write_log_set(folder, truth, seed=0):
    """Two runs to fit to and one to validate on."""
    folder.mkdir(parents=True, exist_ok=True)
    entries = []
    for i, (rate_hz, use) in enumerate(((1.0, "fit"), (1.5, "fit"), (1.25, "validate"))):
        name = f"run{i + 1}.csv"
        table = run(truth, rate_hz, seed + i)
        np.savetxt(
            folder / name, table, delimiter=",", comments="", fmt="%.12f",
            header="t,q1_ref,q2_ref,q1,q2,current1,current2",
        )  # fmt: skip
        entries.append({"file": name, "rate_Hz": rate_hz, "use": use, "controller": "pd"})
    document = {
        "format": 1,
        "name": "five-bar",
        "system": {
            "kind": "five_bar",
            "nominal": {
                "gear_ratio": GEAR, "torque_constant_Nm_per_A": CONSTANT, "rotor_inertia_kg_m2": ROTOR,
                "viscous_Nms_per_rad": VISCOUS, "coulomb_Nm": COULOMB, "sign_width_rad_per_s": WIDTH,
            },
        },
        "controllers": {"pd": {"kind": "not stated"}},
        "sample_time_s": DT,
        "columns": {
            "t": "s", "q1_ref": "rad", "q2_ref": "rad", "q1": "rad", "q2": "rad",
            "current1": "A", "current2": "A",
        },
        "runs": entries,
    }  # fmt: skip
    (folder / "logset.yaml").write_text(yaml.safe_dump(document, sort_keys=False))
    return folder

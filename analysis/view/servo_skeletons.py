"""Skeletons of machines of position servos: a pendulum, and an arm with the joints of the SO-101."""

import numpy as np

from .skeletons import Coordinate, Floats, Skeleton

SO101 = ("rotation", "pitch", "elbow", "wrist_pitch", "wrist_roll", "jaw")
# Of the SO-101 [m]: its model file so101_new_calib.urdf (TheRobotStudio, SO-ARM100) puts elbow, wrist and
# gripper at (-0.11257, -0.028), (-0.1349, 0.0052) and (0, -0.0611) from the joint before.
BASE, FORWARD = 0.117, 0.030  # height of the second joint, and how far it is off the first's axis
UPPER, LOWER, WRIST = float(np.hypot(0.11257, 0.028)), float(np.hypot(0.1349, 0.0052)), 0.0611
JAW = 0.06  # drawn length of the fingers


def pendulum(length: float = 0.1) -> Skeleton:
    """A rod of ``length`` [m] on a servo's shaft, along -z at zero."""

    def place(values: Floats) -> dict[str, Floats]:
        q = float(values[0])
        end = length * np.array([np.sin(q), 0.0, -np.cos(q)])
        back = np.array([[0.0, 0.1, 0.0], [0.0, 0.0, 0.0]]) * length
        return {
            "servo": np.array([[0.0, 0.45, 0.12], [0.0, 0.45, -0.3]]) * length,
            "shaft": np.stack([back[0] * 4.0, back[1]]),
            "rod": np.stack([np.zeros(3), end]),
            "load": end,
        }

    return Skeleton(
        name="pendulum",
        coordinates=(Coordinate(name="angle q", unit="rad", low=-np.pi, high=np.pi, start=0.6),),
        rods={"servo": 0.16 * length, "shaft": 0.04 * length, "rod": 0.05 * length},
        balls={"load": 0.14 * length},
        place=place,
        camera=(0.9 * length, -1.9 * length, 0.2 * length),
        centre=(0.0, 0.0, -0.4 * length),
    )


def so101() -> Skeleton:
    """An arm with the joints of the SO-101; at zero the upper arm stands and the rest is level."""

    def place(values: Floats) -> dict[str, Floats]:
        turn, pitch, elbow, wrist, roll, jaw = values
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        side, up = np.array([-np.sin(turn), np.cos(turn), 0.0]), np.array([0.0, 0.0, 1.0])

        def along(angle: float) -> Floats:
            return np.asarray(np.cos(angle) * out + np.sin(angle) * up)

        shoulder = FORWARD * out + BASE * up
        elbow_at = shoulder + UPPER * along(0.5 * np.pi - pitch)
        wrist_at = elbow_at + LOWER * along(-pitch - elbow)
        ahead = along(-pitch - elbow - wrist)
        gripper = wrist_at + WRIST * ahead
        across = np.cos(roll) * side + np.sin(roll) * np.cross(ahead, side)
        moving = np.cos(jaw) * ahead + np.sin(jaw) * across
        return {
            "post": np.stack([np.zeros(3), BASE * up]),
            "bracket": np.stack([BASE * up, shoulder]),
            "upper arm": np.stack([shoulder, elbow_at]),
            "lower arm": np.stack([elbow_at, wrist_at]),
            "wrist": np.stack([wrist_at, gripper]),
            "finger": np.stack([gripper, gripper + JAW * ahead]),
            "jaw": np.stack([gripper, gripper + JAW * moving]),
            "shoulder": shoulder,
            "elbow": elbow_at,
            "wrist joint": wrist_at,
        }

    spans = (2.0, 1.8, 1.7, 1.7, 2.8, 1.8)
    return Skeleton(
        name="arm",
        coordinates=tuple(
            Coordinate(name=joint, unit="rad", low=-span, high=span, start=start)
            for joint, span, start in zip(SO101, spans, (0.3, 0.3, 0.3, 0.3, 0.0, 0.3))
        ),
        rods={"post": 0.022, "bracket": 0.016, "upper arm": 0.013, "lower arm": 0.011, "wrist": 0.01,
              "finger": 0.005, "jaw": 0.005},
        balls={"shoulder": 0.019, "elbow": 0.017, "wrist joint": 0.014},
        place=place,
        camera=(0.36, -0.38, 0.3),
        centre=(0.12, 0.0, 0.15),
    )  # fmt: skip

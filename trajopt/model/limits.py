"""Limits of joints, and MoveIt's `joint_limits.yaml` that states them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from trajopt.arrays import Floats, Ints, readonly
from trajopt.errors import FileFormatError, JointNotFound

DEFAULT_ACCELERATION_TIME = 0.5
"""A joint without an acceleration limit reaches its velocity limit in this time [s]."""
DEFAULT_VELOCITY = 1.0
"""Velocity limit [rad/s | m/s] of a joint whose description states none."""


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of some joints, one entry a joint, in the order of `joint_names`.

    Attributes:
        joint_names: Names of the joints.
        lower: Lower position limits, shape (n,) [rad | m]; -inf for continuous joints.
        upper: Upper position limits, shape (n,) [rad | m].
        velocity: Largest speeds, shape (n,) [rad/s | m/s].
        acceleration: Largest accelerations, shape (n,) [rad/s^2 | m/s^2].
        jerk: Largest jerks, shape (n,) [rad/s^3 | m/s^3]; inf where unknown.
        effort: Largest torques or forces, shape (n,) [Nm | N]; inf where unknown.
        defaulted: Sentences that name every limit which no file stated and trajopt chose.
    """

    joint_names: tuple[str, ...]
    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    effort: Floats
    defaulted: tuple[str, ...] = ()

    def take(self, index: Ints) -> "JointLimits":
        """Return the limits of the joints at these places, in this order."""
        names = tuple(self.joint_names[int(i)] for i in index)
        kept = tuple(note for note in self.defaulted if note.split(" ", 1)[0] in names)
        return JointLimits(
            names,
            *(
                readonly(array[index])
                for array in (
                    self.lower,
                    self.upper,
                    self.velocity,
                    self.acceleration,
                    self.jerk,
                    self.effort,
                )
            ),
            defaulted=kept,
        )

    def scaled(self, *, velocity: float, acceleration: float) -> "JointLimits":
        """Return these limits with velocity and acceleration multiplied by factors in (0, 1]."""
        return replace(
            self,
            velocity=readonly(self.velocity * velocity),
            acceleration=readonly(self.acceleration * acceleration),
        )


def draw_positions(limits: JointLimits, count: int, *, rng: np.random.Generator) -> Floats:
    """Draw positions evenly within limits; joints without any within half a turn of zero.

    Args:
        limits: Of n joints.
        count: How many to draw.
        rng: Draws them.

    Returns:
        Shape (count, n) [rad | m].
    """
    lower = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    upper = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    return rng.uniform(lower, upper, (count, len(lower)))


def with_stated(limits: JointLimits, stated: Mapping[str, Mapping[str, Any]]) -> JointLimits:
    """Apply the entries of a `joint_limits.yaml` and default what nobody stated.

    Args:
        limits: What the robot description says; acceleration may hold nan for "not stated".
        stated: Joint name -> `max_velocity`, `max_acceleration`, `max_jerk`, `min_position`,
            `max_position`, `max_effort`, each with its `has_..._limits` flag.

    Raises:
        JointNotFound: If an entry names no movable joint.
    """
    columns: dict[str, tuple[tuple[str, Floats], ...]] = {
        "has_velocity_limits": (("max_velocity", np.array(limits.velocity)),),
        "has_acceleration_limits": (("max_acceleration", np.array(limits.acceleration)),),
        "has_jerk_limits": (("max_jerk", np.array(limits.jerk)),),
        "has_effort_limits": (("max_effort", np.array(limits.effort)),),
        "has_position_limits": (
            ("min_position", np.array(limits.lower)),
            ("max_position", np.array(limits.upper)),
        ),
    }
    for name, entry in stated.items():
        if name not in limits.joint_names:
            raise JointNotFound("joint", name, limits.joint_names)
        place = limits.joint_names.index(name)
        for flag, keys in columns.items():
            for key, array in keys:
                if entry.get(flag, key in entry) and key in entry:
                    array[place] = float(entry[key])
    (_, velocity), (_, acceleration) = (
        columns["has_velocity_limits"][0],
        columns["has_acceleration_limits"][0],
    )
    defaulted: list[str] = []
    for place, name in enumerate(limits.joint_names):
        if not (np.isfinite(velocity[place]) and velocity[place] > 0.0):
            velocity[place] = DEFAULT_VELOCITY
            defaulted.append(f"{name} velocity {velocity[place]:g} (no limit stated)")
        if not (np.isfinite(acceleration[place]) and acceleration[place] > 0.0):
            acceleration[place] = velocity[place] / DEFAULT_ACCELERATION_TIME
            defaulted.append(f"{name} acceleration {acceleration[place]:g} (no limit stated)")
    (_, lower), (_, upper) = columns["has_position_limits"]
    return JointLimits(
        limits.joint_names,
        readonly(lower),
        readonly(upper),
        readonly(velocity),
        readonly(acceleration),
        readonly(columns["has_jerk_limits"][0][1]),
        readonly(columns["has_effort_limits"][0][1]),
        tuple(defaulted),
    )


def read_joint_limits(path: Path) -> Mapping[str, Mapping[str, Any]]:
    """Read the `joint_limits` mapping of MoveIt's `joint_limits.yaml`.

    Raises:
        FileFormatError: If the file is missing, is no YAML, or has no such mapping.
    """
    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        document = yaml.load(path.read_text(), loader)
    except (OSError, yaml.YAMLError) as error:
        raise FileFormatError(str(path), str(error)) from error
    entries = (
        cast("dict[object, object]", document).get("joint_limits") if isinstance(document, dict) else None
    )
    if not isinstance(entries, dict):
        raise FileFormatError(str(path), "has no mapping `joint_limits`")
    return cast("dict[str, dict[str, Any]]", entries)

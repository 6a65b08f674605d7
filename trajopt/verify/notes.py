"""Notes of a certificate."""

from heapq import nsmallest

import numpy as np

from trajopt.robot.joints import joint_unit
from trajopt.robot.limits import JointLimits
from trajopt.scene.payload import payloads
from trajopt.scene.reduced import ReducedModel
from trajopt.values.errors import shown
from trajopt.values.printed import in_unit
from trajopt.verify.kernel.motion import Motion

_MOST_NAMES = 8


def notes(motion: Motion, limits: JointLimits) -> tuple[str, ...]:
    """Collect the notes on a motion judged with given limits."""
    reduced = motion.reduced
    return (
        *_trajectory_notes(motion, limits),
        *(f"limit chosen: {note}" for note in limits.defaulted),
        *_jerk_notes(limits),
        *_joint_notes(reduced),
        *(f"mesh of {note}" for note in reduced.scene.robot.mesh_notes),
        *(f"mesh of {note}" for item in reduced.scene.objects.values() for note in item.notes),
        *_pair_notes(reduced),
    )


def _trajectory_notes(motion: Motion, limits: JointLimits) -> list[str]:
    found: list[str] = []
    if not motion.differentiable:
        found.append(
            "the trajectory is linear between its points: its velocity jumps there, and it states no "
            "accelerations, so speed is judged for each segment, acceleration, torque and rest are not"
        )
    elif np.isfinite(limits.effort).any():
        reduced = motion.reduced
        weighed = [item.name for item in payloads(reduced)]
        if weighed:
            names = _listed(sorted(weighed), count=len(weighed))
            found.append(f"torques count the mass of {names} as spread evenly over its shape")
        owners = {body.owner for body in reduced.bodies if body.joint != 0}
        carried = sorted((owners & set(reduced.scene.objects)) - set(weighed))
        if carried:
            found.append(f"torques are judged without the mass of {_listed(carried, count=len(carried))}")
    return found


def _jerk_notes(limits: JointLimits) -> list[str]:
    free = [
        name for name, limit in zip(limits.joint_names, limits.jerk, strict=True) if not np.isfinite(limit)
    ]
    if not free:
        return []
    named = _listed(free, count=len(free))
    return [f"jerk is not limited, as no limit is stated: {named}; Robot.with_jerk_limits chooses limits"]


def _joint_notes(reduced: ReducedModel) -> list[str]:
    robot = reduced.scene.robot
    beyond = np.maximum(reduced.start - robot.limits.upper, robot.limits.lower - reduced.start)
    moved = set(reduced.model.names)
    return [
        f"{name} stands {in_unit(beyond[joint], joint_unit(robot.model, name))} outside its limits; "
        f"it is not in group {shown(reduced.group)}"
        for joint, name in enumerate(robot.joint_names)
        if beyond[joint] > 1e-9 and name not in moved
    ]


def _pair_notes(reduced: ReducedModel) -> list[str]:
    found = [
        f"contact of {allowance.a} and {allowance.b} is accepted ({allowance.name}): at most "
        f"{1000 * allowance.depth:g} mm deep, first {allowance.first:g} s and last {allowance.last:g} s"
        for allowance in dict.fromkeys(allowance for _, allowance in reduced.pairs.allowances)
    ]
    if not any(body.joint for body in reduced.bodies):
        found.append("no moving link has a collision shape: no clearance is checked")
    immobile = reduced.pairs.immobile
    if immobile:
        first = nsmallest(_MOST_NAMES, map(sorted, immobile))
        names = _listed([" - ".join(pair) for pair in first], count=len(immobile))
        found.append(f"pairs that do not move against each other, not judged: {names}")
    return found


def _listed(names: list[str], *, count: int) -> str:
    more = count - _MOST_NAMES
    return ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")

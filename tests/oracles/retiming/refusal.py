"""Why a path cannot be timed: the limit that no speed can hold."""

import numpy as np

from tests.oracles.retiming.constraints import TorqueLimits
from tests.oracles.retiming.discretised_path import DiscretisedPath
from tests.oracles.retiming.peaks import Slowdown
from trajopt.robot.joints import JointLimits, LimitKind
from trajopt.timing.retiming import RetimeFailure

GRAVITY = 1.0 - 1e-6
"""Part of a torque limit that holding still may take; a path that needs more is refused."""

ROOM = 1e-3
"""Part of the longest duration that a path may take by the limit of one joint alone: it bends, and others are
slower there."""


def unholdable(on: DiscretisedPath, limits: JointLimits, torque: TorqueLimits | None) -> RetimeFailure | None:
    """Find the point where holding still takes more torque than there is.

    The arm could only swing through such a point, and never stop there.
    """
    if torque is None:
        return None
    still = on.rows.c[:, -len(torque.joints) :]
    usable = torque.limit > 0.0
    part = np.where(usable, np.abs(still) / np.where(usable, torque.limit, 1.0), np.inf)
    row, column = np.unravel_index(int(part.argmax()), part.shape)
    if part[row, column] < GRAVITY:
        return None
    joint = limits.joint_names[int(torque.joints[column])]
    return RetimeFailure(
        f"{joint} needs {abs(still[row, column]):.4g} only to hold still there, "
        f"its effort limit is {torque.limit[column]:.4g}",
        joint,
        float(on.s[row] / on.s[-1]),
    )


def exceeded(
    on: DiscretisedPath, found: Slowdown, limits: JointLimits, torque: TorqueLimits | None
) -> RetimeFailure:
    """Name the limit that a trajectory exceeds however slow it is."""
    speeds, joints = on.slope.shape[1], len(limits.joint_names)
    kind, place = (0, found.column) if found.column < speeds else (1, found.column - speeds)
    if kind == 1 and place >= joints and torque is not None:
        kind, place = 2, int(torque.joints[place - joints])
    joint = limits.joint_names[place]
    limit = (LimitKind.VELOCITY, LimitKind.ACCELERATION, None)[kind]
    mimic = "" if limit is None else limits.because(joint, limit)
    return RetimeFailure(
        f"the {'effort' if limit is None else limit.value} limit of {joint}{mimic} "
        "is exceeded there at any speed",
        joint,
        float(on.s[found.piece] / on.s[-1]),
    )

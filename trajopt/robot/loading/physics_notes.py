"""Notes on implausible efforts and inertias of a description."""

from collections.abc import Collection

import numpy as np
import pinocchio as pin

from trajopt.robot.joints import JointLimits, configuration, draw_positions, effort_unit
from trajopt.values.errors import listed

POSTURES = 64
"""Random postures: a joint that gravity overloads in 70 % of all postures is reported with a probability
of 99.9 %.
"""


def effort_notes(model: pin.Model, limits: JointLimits, exempt: Collection[str]) -> tuple[str, ...]:
    """Return notes on joints without an effort limit, and on those that gravity mostly overloads."""
    said: list[str] = []
    spoken = [(place, name) for place, name in enumerate(limits.joint_names) if name not in exempt]
    free = [name for place, name in spoken if np.isinf(limits.effort[place])]
    if free:
        said.append(f"no effort limit is stated, or 0, so torque is not limited: {listed(free)}")
    data, still = model.createData(), np.zeros(model.nv)
    torques = np.zeros((POSTURES, model.nv))
    for row, posture in zip(
        torques, draw_positions(limits, POSTURES, rng=np.random.default_rng(0)), strict=True
    ):
        row[:] = pin.rnea(model, data, configuration(model, posture), still, still)
    # The median; numpy's own imports masked arrays for it.
    needed = np.sort(np.abs(torques), axis=0)[POSTURES // 2 - 1 : POSTURES // 2 + 1].mean(axis=0)
    weak = [
        f"{name} ({limits.effort[place]:.4g} of {needed[place]:.4g} {effort_unit(model, name)})"
        for place, name in spoken
        if needed[place] > limits.effort[place]
    ]
    if weak:
        said.append(
            f"effort limits that do not hold the robot still in most postures: {listed(weak)}; "
            "Robot.with_torque_scaling raises limits of torque or turns them off"
        )
    return tuple(said)


ROUNDING = 1e-3
"""Accepted negative moment, as a share of the largest one: files have few digits."""


def inertia_notes(model: pin.Model) -> tuple[str, ...]:
    """Return a note on joints that carry a negative moment of inertia, if there are any."""
    negative: list[str] = []
    for name, inertia in zip(list(model.names)[1:], list(model.inertias)[1:], strict=True):
        moments = np.linalg.eigvalsh(np.asarray(inertia.inertia))
        if moments[0] < -ROUNDING * np.abs(moments).max():
            negative.append(name)
    if not negative:
        return ()
    return (
        f"bodies on {listed(negative)} have negative moments of inertia, which is impossible: torques of "
        "motions and the simulation are wrong; `trajopt srdf` names the links",
    )

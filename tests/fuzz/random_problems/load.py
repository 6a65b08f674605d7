"""What joints bear: torques by Pinocchio from the URDF, and effort limits that a motion just keeps."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from tests.fuzz.random_problems.case import Arm
from trajopt.values.arrays import Floats

LEAST = 1.0
"""No effort limit is less than this [Nm, N]: friction alone is more."""


@cache
def _model(urdf: str) -> pin.Model:
    return pin.buildModelFromXML(urdf)


def torques(arm: Arm, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
    """Return what the driven joints bear, those of their followers too, shape (t, n) [Nm | N]."""
    chain, model = arm.chain, _model(arm.source.urdf)
    data = model.createData()
    matrix, _ = chain.follows
    joints = [model.joints[model.getJointId(joint.name)] for joint in chain.moving]
    values, rates, rises = chain.all_joints(positions), velocities @ matrix.T, accelerations @ matrix.T
    found = np.zeros((len(positions), len(chain.driven)))
    for look in range(len(positions)):
        q, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        for joint, value, rate, rise in zip(joints, values[look], rates[look], rises[look], strict=True):
            q[joint.idx_q : joint.idx_q + joint.nq] = _configuration(joint, value)
            v[joint.idx_v], a[joint.idx_v] = rate, rise
        tau = pin.rnea(model, data, q, v, a)
        found[look] = np.array([tau[joint.idx_v] for joint in joints]) @ matrix
    return found


def _configuration(joint: pin.JointModel, value: float) -> Sequence[float]:
    return (value,) if joint.nq == 1 else (np.cos(value), np.sin(value))


def with_tight_efforts(arm: Arm, corners: Floats, rng: np.random.Generator) -> Arm:
    """Return the arm with effort limits a little over what holding still takes along a polyline."""
    parts = [np.linspace(first, last, 100) for first, last in pairwise(corners)]
    fine = np.concatenate(parts)
    still = np.zeros_like(fine)
    borne = np.abs(torques(arm, fine, still, still)).max(axis=0)
    most = np.maximum(borne * rng.uniform(1.1, 2.0, len(borne)), LEAST)
    efforts = dict(zip(arm.chain.driven, most.tolist(), strict=True))
    root = ElementTree.fromstring(arm.source.urdf)
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if limit is not None and joint.get("name") in efforts:
            limit.set("effort", repr(efforts[joint.get("name", "")]))
    urdf = ElementTree.tostring(root, encoding="unicode")
    return replace(arm, source=replace(arm.source, urdf=urdf), efforts=efforts)

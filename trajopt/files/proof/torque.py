"""Torque limits as a proof states them."""

from dataclasses import dataclass

import numpy as np

from trajopt.files.proof.leaves import SLACK, SURE
from trajopt.files.proof.requirements import RequirementRecord, stated
from trajopt.problem.requirements import GravityTorque
from trajopt.robot.joints import JointLimits
from trajopt.scene.reduced import loaded_model
from trajopt.values.arrays import Bools, Floats
from trajopt.verify.checks.torques import inverse_dynamics
from trajopt.verify.kernel.motion import JudgedMotion

SHORTEST_OF_TORQUE = 1e-3
"""Shorter intervals are not cut for torque [s], which may just keep its limit."""
CROSS = np.array(
    [[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
     [[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
     [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]]
)  # fmt: skip
"""A cross product has the numbers CROSS[i, j, k] a[j] b[k]."""

MAPPED, SPREAD, APPLIED = "ij,ocj->oci", "...,oc->oc...", "j,ocij->oci"
"""Linear operations: constant matrix times vector, number times constant, matrix times constant vector."""
OUTWARD, INWARD, PRODUCT = "cij,cj->ci", "cji,cj->ci", "cij,cjk->cik"
"""A rotation, or its inverse, times a vector; a rotation times another."""


def stated_torque(motion: JudgedMotion, limits: JointLimits) -> RequirementRecord | None:
    words = f"torque: sampled at {len(inverse_dynamics(motion)[0])} times, not proven"
    return _stated(motion, limits.effort, still=False, words=words)


@stated.register
def _(requirement: GravityTorque, motion: JudgedMotion, *, always: bool) -> RequirementRecord | None:
    return _stated(motion, requirement.share * motion.reduced.limits.effort, still=True) if always else None


def _stated(
    motion: JudgedMotion, limits: Floats, *, still: bool, words: str = ""
) -> RequirementRecord | None:
    limited, reduced = np.flatnonzero(np.isfinite(limits)), motion.reduced
    if not len(limited):
        return None
    model, dynamics = loaded_model(reduced), _InverseDynamics(motion, still=still)
    loads = [
        [joint, inertia.mass, inertia.lever.tolist(), inertia.inertia[np.triu_indices(3)].tolist()]
        for joint, inertia in enumerate(model.inertias)
        if joint and inertia.mass > 0.0
    ]
    most = limits[limited] * (1.0 + 0.9 * motion.options.excess)

    def shown(begin: Floats, end: Floats) -> Bools:
        sides = (np.abs(dynamics.at(begin, time)[:, limited]) for time in (begin, end))
        off = dynamics.second(begin, end)[:, limited] * ((end - begin) ** 2 / 8.0)[:, None]
        return np.all(SURE * (np.maximum(*sides) + off) + SLACK <= most, axis=1)

    return RequirementRecord(
        {
            "kind": "gravity torque" if still else "torque",
            "gravity": model.gravity.linear.tolist(),
            "loads": loads,
            "rotors": model.armature.tolist()
            + [0.0] * (len(motion.among.kinematics.parents) - model.njoints),
            "limits": [[joint, float(limits[joint])] for joint in limited.tolist()],
        },
        shown,
        SHORTEST_OF_TORQUE,
        words,
    )


@dataclass(frozen=True, eq=False)
class _Series:
    """Taylor coefficients, as in the checker: centres and radii, shape (terms, cells, ...)."""

    centre: Floats
    radius: Floats

    def __add__(self, other: "_Series") -> "_Series":
        terms = min(len(self.centre), len(other.centre))
        return _Series(self.centre[:terms] + other.centre[:terms], self.radius[:terms] + other.radius[:terms])

    def by(self, equation: str, matrix: Floats) -> "_Series":
        return _Series(
            np.einsum(equation, matrix, self.centre), np.einsum(equation, np.abs(matrix), self.radius)
        )

    def scaled(self, factor: float) -> "_Series":
        return _Series(factor * self.centre, abs(factor) * self.radius)

    def plus(self, constant: Floats) -> "_Series":
        return _Series(np.concatenate((self.centre[:1] + constant, self.centre[1:])), self.radius)

    def column(self, place: int) -> "_Series":
        return _Series(self.centre[:, :, place], self.radius[:, :, place])

    @property
    def rate(self) -> "_Series":
        orders = np.arange(1.0, len(self.centre)).reshape(-1, *[1] * (self.centre.ndim - 1))
        return _Series(orders * self.centre[1:], orders * self.radius[1:])

    def cross(self, other: "_Series") -> "_Series":
        return self.times("ijk,cj,ck->ci", other, CROSS)

    def times(self, equation: str, other: "_Series", *tensor: Floats) -> "_Series":
        sizes = [np.abs(each) for each in tensor]
        orders = range(min(len(self.centre), len(other.centre)))
        centres, radii = [list[Floats]() for _ in orders], [list[Floats]() for _ in orders]
        for one, (a, r) in enumerate(zip(self.centre, self.radius, strict=True)):
            for two, (b, s) in enumerate(zip(other.centre, other.radius, strict=True)):
                if one + two in orders:
                    centres[one + two].append(np.einsum(equation, *tensor, a, b))
                    radii[one + two].append(np.einsum(equation, *sizes, np.abs(a), s))
                    radii[one + two].append(np.einsum(equation, *sizes, r, np.abs(b) + s))
        return _Series(np.array([sum(each) for each in centres]), np.array([sum(each) for each in radii]))


class _InverseDynamics:
    """The equations of the checker's `rule_torque` in plain doubles."""

    def __init__(self, motion: JudgedMotion, *, still: bool) -> None:
        self._motion, self._still = motion, still
        orders = [motion.moving(order) for order in range(4)]
        self._orders = [*orders, orders[-1].derivative()]
        self._model = loaded_model(motion.reduced)

    def at(self, begin: Floats, times: Floats) -> Floats:
        knots = self._motion.trajectory.times
        piece = np.clip(np.searchsorted(knots, begin, side="right") - 1, 0, len(knots) - 2)
        values = np.array([order.at(piece, times - knots[piece]) for order in self._orders[:3]])
        return self._torques(_taylor(values, np.zeros_like(values))).centre[0]

    def second(self, begin: Floats, end: Floats) -> Floats:
        bounds = [order.range(begin, end) for order in self._orders]
        low, high = (np.array([bound[side] for bound in bounds]) for side in (0, 1))
        found = self._torques(_taylor((high + low) / 2.0, (high - low) / 2.0))
        return 2.0 * (np.abs(found.centre[2]) + found.radius[2])

    def _torques(self, positions: _Series) -> _Series:
        model, arm, still = self._model, self._motion.kinematics, self._still
        joints = list(enumerate(arm.parents))[1:]
        columns = [positions.column(joint - 1) for joint, _ in joints]
        none = positions.column(0).by(SPREAD, np.zeros(3))
        places, axes, spins = (
            [(positions.column(0).by(SPREAD, np.zeros((3, 3))).plus(np.eye(3)), none)],
            [none],
            [none],
        )
        for joint, parent in joints:
            turn, origin = places[parent]
            own, shift = self._placed(joint, columns[joint - 1])
            places.append((turn.times(PRODUCT, own), origin + turn.times(OUTWARD, shift)))
            direction = model.jointPlacements[joint].rotation @ arm.axes[joint]
            axes.append(turn.by(APPLIED, direction))
            turning = axes[-1].times("ci,c->ci", columns[joint - 1].rate)
            spins.append(spins[parent] + turning if arm.revolute[joint] else spins[parent])
        force, moment = [none] * len(places), [none] * len(places)
        for joint, load in list(enumerate(model.inertias))[1:]:
            turn, origin = places[joint]
            lever = turn.by(APPLIED, load.lever)
            push, spun = none.plus(-load.mass * model.gravity.linear), none
            if not still:
                push = push + (origin + lever).rate.rate.scaled(load.mass)
                inward = turn.times(INWARD, spins[joint])
                spun = turn.times(OUTWARD, inward.by(MAPPED, load.inertia)).rate
            force[joint], moment[joint] = push, spun + lever.cross(push)
        needed = [none.column(0)] * len(places)
        for joint, parent in reversed(joints):
            own = axes[joint].times("ci,ci->c", (moment if arm.revolute[joint] else force)[joint])
            if not still:
                own = own + columns[joint - 1].rate.rate.scaled(float(model.armature[joint - 1]))
            needed[joint] = own
            lever = places[joint][1] + places[parent][1].scaled(-1.0)
            force[parent] = force[parent] + force[joint]
            moment[parent] = moment[parent] + moment[joint] + lever.cross(force[joint])
        every = [
            np.stack([getattr(each, side) for each in needed[1:]], axis=2) for side in ("centre", "radius")
        ]
        return _Series(*every).by("jn,ocj->ocn", self._motion.reduced.mimic_matrix)

    def _placed(self, joint: int, position: _Series) -> tuple[_Series, _Series]:
        where, axis = self._model.jointPlacements[joint], self._motion.kinematics.axes[joint]
        fixed, turns = np.array(where.rotation), bool(self._motion.kinematics.revolute[joint])
        of_sine = fixed @ np.einsum("ijk,j->ik", CROSS, axis) * turns
        of_cosine = -of_sine @ np.einsum("ijk,j->ik", CROSS, axis)
        sine, cosine = _sine_and_cosine(position)
        own = (sine.by(SPREAD, of_sine) + cosine.by(SPREAD, of_cosine)).plus(fixed - of_cosine)
        return own, position.by(SPREAD, fixed @ axis * (not turns)).plus(where.translation)


def _taylor(centre: Floats, radius: Floats) -> _Series:
    factorial = np.cumprod([1.0, *range(1, len(centre))])[:, None, None]
    return _Series(centre / factorial, radius / factorial)


def _sine_and_cosine(angle: _Series) -> tuple[_Series, _Series]:
    sine, cosine = (_Series(wave(angle.centre[:1]), angle.radius[:1]) for wave in (np.sin, np.cos))
    for order in range(1, len(angle.centre)):
        found = [each.times("c,c->c", angle.rate) for each in (cosine, sine)]
        (s, c) = (
            _Series(each.centre[-1:], each.radius[-1:]).scaled(sign / order)
            for each, sign in zip(found, (1.0, -1.0), strict=True)
        )
        sine, cosine = _joined(sine, s), _joined(cosine, c)
    return sine, cosine


def _joined(one: _Series, other: _Series) -> _Series:
    return _Series(np.concatenate((one.centre, other.centre)), np.concatenate((one.radius, other.radius)))

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

MAPPED, ALONG, SPREAD = "ij,ocj->oci", "i,oc->oci", "ij,oc->ocij"
"""Linear operations: a matrix times a vector, a vector or matrix times a number."""
OUTWARD, INWARD = "cij,cj->ci", "cji,cj->ci"
"""A rotation, or its inverse, times a vector."""


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
    centre: Floats
    radius: Floats

    def __add__(self, other: "_Series") -> "_Series":
        few, many = sorted((self, other), key=lambda each: len(each.centre))
        rest = np.zeros((len(many.centre) - len(few.centre), *few.centre.shape[1:]))
        parts = [np.concatenate((each, rest)) for each in (few.centre, few.radius)]
        return _Series(parts[0] + many.centre, parts[1] + many.radius)

    def by(self, equation: str, matrix: Floats) -> "_Series":
        return _Series(
            np.einsum(equation, matrix, self.centre), np.einsum(equation, np.abs(matrix), self.radius)
        )

    def scaled(self, factor: float) -> "_Series":
        return _Series(factor * self.centre, abs(factor) * self.radius)

    def column(self, place: int) -> "_Series":
        return _Series(self.centre[:, :, place], self.radius[:, :, place])

    def cross(self, other: "_Series") -> "_Series":
        return self.times("ijk,cj,ck->ci", other, CROSS)

    def times(self, equation: str, other: "_Series", *tensor: Floats) -> "_Series":
        sizes = [np.abs(each) for each in tensor]
        orders = range(max(len(self.centre), len(other.centre)))
        centres, radii = [list[Floats]() for _ in orders], [list[Floats]() for _ in orders]
        for one, (a, r) in enumerate(zip(self.centre, self.radius, strict=True)):
            for two, (b, s) in enumerate(zip(other.centre, other.radius, strict=True)):
                if one + two in orders:
                    centres[one + two].append(np.einsum(equation, *tensor, a, b))
                    radii[one + two].append(np.einsum(equation, *sizes, np.abs(a), s))
                    radii[one + two].append(np.einsum(equation, *sizes, r, np.abs(b) + s))
        return _Series(np.array([sum(each) for each in centres]), np.array([sum(each) for each in radii]))


class _InverseDynamics:
    """Newton's and Euler's equations in plain doubles, as the checker's `inverse_dynamics` has them."""

    def __init__(self, motion: JudgedMotion, *, still: bool) -> None:
        self._motion, self._still = motion, still
        orders = [motion.moving(order) for order in range(4)]
        self._orders = [*orders, orders[-1].derivative()]
        self._model = loaded_model(motion.reduced)

    def at(self, begin: Floats, times: Floats) -> Floats:
        knots = self._motion.trajectory.times
        piece = np.clip(np.searchsorted(knots, begin, side="right") - 1, 0, len(knots) - 2)
        values = [order.at(piece, times - knots[piece])[None] for order in self._orders[:3]]
        return self._torques([_Series(each, np.zeros_like(each)) for each in values]).centre[0]

    def second(self, begin: Floats, end: Floats) -> Floats:
        bounds = [order.range(begin, end) for order in self._orders]
        scale = np.array((1.0, 1.0, 0.5))[:, None, None]
        low, high = (np.array([bound[side] for bound in bounds]) for side in (0, 1))
        found = self._torques(
            [
                _Series(
                    scale * (high + low)[order : order + 3] / 2.0,
                    scale * (high - low)[order : order + 3] / 2.0,
                )
                for order in range(3)
            ]
        )
        return 2.0 * (np.abs(found.centre[2]) + found.radius[2])

    def _torques(self, state: list[_Series]) -> _Series:
        if self._still:
            state = [state[0], state[1].scaled(0.0), state[2].scaled(0.0)]
        model, arm = self._model, self._motion.kinematics
        still = _constant(np.zeros((len(state[0].centre[0]), 3)))
        push = [_Series(still.centre - model.gravity.linear, still.radius)]
        spin, swing, places = [still], [still], [(still, still)]
        for joint, parent in list(enumerate(arm.parents))[1:]:
            position, velocity, acceleration = (each.column(joint - 1) for each in state)
            turn, shift = self._placed(joint, position)
            places.append((turn, shift))
            push.append(turn.times(INWARD, push[parent] + _accelerated(spin[parent], swing[parent], shift)))
            spin.append(turn.times(INWARD, spin[parent]))
            swing.append(turn.times(INWARD, swing[parent]))
            rate, increase = (each.by(ALONG, arm.axes[joint]) for each in (velocity, acceleration))
            aside = spin[-1].cross(rate)
            if arm.revolute[joint]:
                spin[-1], swing[-1] = spin[-1] + rate, swing[-1] + aside + increase
            else:
                push[-1] = push[-1] + aside + aside + increase
        force, moment = [still] * len(spin), [still] * len(spin)
        for joint, load in list(enumerate(model.inertias))[1:]:
            centre = _constant(np.broadcast_to(load.lever, still.centre[0].shape))
            inertial = (push[joint] + _accelerated(spin[joint], swing[joint], centre)).scaled(load.mass)
            momentum = spin[joint].by(MAPPED, load.inertia)
            turning = swing[joint].by(MAPPED, load.inertia) + spin[joint].cross(momentum)
            force[joint], moment[joint] = inertial, turning + centre.cross(inertial)
        needed = [still.column(0)] * len(arm.parents)
        for joint in range(len(arm.parents) - 1, 0, -1):
            (turn, shift), parent = places[joint], arm.parents[joint]
            borne = (moment if arm.revolute[joint] else force)[joint].by("i,oci->oc", arm.axes[joint])
            needed[joint] = borne + state[2].column(joint - 1).scaled(float(model.armature[joint - 1]))
            outer = turn.times(OUTWARD, force[joint])
            force[parent] = force[parent] + outer
            moment[parent] = moment[parent] + turn.times(OUTWARD, moment[joint]) + shift.cross(outer)
        every = [
            np.stack([getattr(each, side) for each in needed[1:]], axis=2) for side in ("centre", "radius")
        ]
        return _Series(*every).by("jn,ocj->ocn", self._motion.reduced.mimic_matrix)

    def _placed(self, joint: int, position: _Series) -> tuple[_Series, _Series]:
        where, axis = self._model.jointPlacements[joint], self._motion.kinematics.axes[joint]
        fixed, cells = np.array(where.rotation), len(position.centre[0])
        origin = _constant(np.broadcast_to(where.translation, (cells, 3)))
        if not self._motion.kinematics.revolute[joint]:
            return _constant(np.broadcast_to(fixed, (cells, 3, 3))), origin + position.by(ALONG, fixed @ axis)
        skew = np.einsum("ijk,j->ik", CROSS, axis)
        sine, cosine = _sine_and_cosine(position)
        turned = sine.by(SPREAD, fixed @ skew) + cosine.by(SPREAD, -fixed @ skew @ skew)
        return turned + _constant(np.broadcast_to(fixed + fixed @ skew @ skew, (cells, 3, 3))), origin


def _constant(value: Floats) -> _Series:
    return _Series(value[None], np.zeros_like(value)[None])


def _accelerated(spin: _Series, swing: _Series, arm: _Series) -> _Series:
    return swing.cross(arm) + spin.cross(spin.cross(arm))


def _sine_and_cosine(angle: _Series) -> tuple[_Series, _Series]:
    sine, cosine = (_Series(wave(angle.centre[:1]), angle.radius[:1]) for wave in (np.sin, np.cos))
    if len(angle.centre) == 1:
        return sine, cosine
    rate, bend = (_Series(angle.centre[at : at + 1], angle.radius[at : at + 1]) for at in (1, 2))
    half = rate.times("c,c->c", rate).scaled(0.5)
    product = [[wave.times("c,c->c", each) for each in (rate, bend, half)] for wave in (sine, cosine)]
    sines = (sine, product[1][0], product[1][1] + product[0][2].scaled(-1.0))
    cosines = (cosine, product[0][0].scaled(-1.0), (product[0][1] + product[1][2]).scaled(-1.0))
    return _joined(sines), _joined(cosines)


def _joined(orders: tuple[_Series, ...]) -> _Series:
    return _Series(
        np.concatenate([each.centre for each in orders]), np.concatenate([each.radius for each in orders])
    )

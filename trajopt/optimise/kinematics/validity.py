"""Validity of a configuration, by the judge's own code, with the reasons if it is invalid."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from trajopt.geometry import Evaluator, evaluator
from trajopt.optimise.terms.joint_positions import without_followers
from trajopt.optimise.terms.requirement import constrain
from trajopt.problem.motion import Motion
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import WHOLE, units_of
from trajopt.problem.stated import check_names
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, Value, floats, number, one_of, sequence
from trajopt.values.errors import ProblemError, ShapeError, shown
from trajopt.values.printed import in_degrees, in_length
from trajopt.verify import Check, Examination, Judge, PairDistance


@dataclass(frozen=True, kw_only=True, eq=False)
class Validity(Value):
    """Verdict of the judge on a configuration.

    Attributes:
        positions: Of the group's joints, shape (n,) [rad | m].
        margin: Required clearance [m].
        left_out: Objects that change with time, which are not checked; `scene.still_at(time)` freezes them.
    """

    positions: Floats
    examination: Examination
    margin: float
    checks: tuple[Check, ...]
    left_out: tuple[str, ...] = ()

    @property
    def valid(self) -> bool:
        """Whether nothing is wrong."""
        return not self.reasons

    @property
    def too_near(self) -> PairDistance | None:
        """The nearest pair, if it is apart by less than the margin."""
        nearest = self.examination.smallest
        if nearest is None or nearest in self.examination.collisions:
            return None
        return nearest if nearest.distance < self.margin else None

    @property
    def reasons(self) -> tuple[str, ...]:
        """A sentence for each thing that is wrong: pairs and depth, joints and limits, requirements."""
        found = [pair.words for pair in self.examination.collisions]
        near = self.too_near
        if near is not None:
            found.append(
                f"{near.first} is {1000.0 * near.distance:.1f} mm from {near.second}, "
                f"the margin is {1000.0 * self.margin:.1f} mm"
            )
        found += [joint.words for joint in self.examination.out_of_limits]
        broken = (check for check in self.checks if check.required and not check.holds)
        found += [f"{check.name} of {check.subject}: {check.detail}" for check in broken]
        return tuple(found)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data."""
        nearest = self.examination.smallest
        return {
            "valid": self.valid,
            "reasons": list(self.reasons),
            "positions": self.positions.tolist(),
            "nearest_pair": None if nearest is None else vars(nearest).copy(),
            "left_out": list(self.left_out),
        }

    def __str__(self) -> str:
        beside = (
            f" (not looked at, since it changes with time: {', '.join(self.left_out)})"
            if self.left_out
            else ""
        )
        return ("valid" if self.valid else "not valid: " + "; ".join(self.reasons)) + beside


def validity(
    reduced: ReducedModel,
    positions: ArrayLike,
    *,
    requirements: Sequence[Requirement] = (),
    margin: float = 0.0,
) -> Validity:
    """Judge a configuration: collisions, limits and requirements.

    Objects that change with time (move, appear, expire) are not checked, and named in `left_out`; use a model
    of `scene.still_at(time)` to check them.

    Args:
        positions: Of the group's joints, shape (n,) [rad | m].
        margin: Clearance to keep from everything [m].

    Raises:
        ShapeError: If there is not one finite position for each joint, or the margin is negative.
        NameNotFound: If a requirement names an unknown frame or joint.
    """
    judge = Judge(reduced)
    if number("margin", margin) < 0.0:
        raise ShapeError("margin", f"is negative: {margin:g} m")
    place = floats("positions", positions, (len(reduced.joint_names),))
    return Validity(
        positions=place,
        examination=judge.examine(place),
        margin=margin,
        checks=judge.check(place, requirements_of(reduced, "requirements", requirements)),
        left_out=reduced.scene.changing,
    )


def clear(query: Evaluator, positions: Floats, margin: Floats) -> Bools:
    """Return a mask (S,) of the configurations (S, n) at which pairs keep their margins (p,) [m]."""
    free = np.ones(len(positions), dtype=np.bool_)
    free[query.close_pairs(positions, margin).sample] = False
    return free


def pair_margins(reduced: ReducedModel, margin: float | None) -> Floats:
    """Return the clearance of each pair, at least the required one, shape (p,) [m]; by default the scene's.

    Raises:
        ShapeError: If the margin is negative or not finite.
    """
    if margin is None:
        return reduced.pairs.margin
    if number("margin", margin) < 0.0:
        raise ShapeError("margin", f"is negative: {margin:g} m")
    return np.maximum(margin, reduced.pairs.required)


SHOWN: Mapping[str, Callable[[float], str]] = {"m": in_length, "rad": in_degrees, "": "{:.3g}".format}
"""Format of a violation, by its unit."""


def missed_at(reduced: ReducedModel, required: Sequence[Requirement], positions: Floats) -> str:
    """Return the largest violation of each unit: "12 mm", "12 mm and 0.9 deg", or "0.2" without a unit."""
    motion = Motion.single(positions, evaluator(reduced))
    missed: dict[str, float] = {"m": 0.0, "rad": 0.0, "": 0.0}
    for item in without_followers(required, reduced):
        for bound in constrain(item, reduced, WHOLE, inset=0.0):
            rows, units = bound.residual.linearise(motion), units_of(bound.residual) or ("",)
            lower, upper = bound.bounds(rows)
            outside = np.maximum(lower - rows.value, rows.value - upper)
            for component, off in zip(rows.component.tolist(), outside.tolist(), strict=True):
                unit = units[component if len(units) > 1 else 0]
                missed[unit] = max(missed[unit], off if off > bound.tolerance else 0.0)
    said = " and ".join(SHOWN[unit](off) for unit, off in missed.items() if off > 0.0)
    return said or "next to nothing"  # of what is aimed at inside the tolerances


def count_of(name: str, value: int) -> int:
    """Return an integer of at least 1.

    Raises:
        ProblemError: If it is not an integer.
        ShapeError: If it is smaller.
    """
    if one_of(name, value, int) < 1:
        raise ShapeError(name, f"must be at least 1, is {value}")
    return value


def requirements_of(
    reduced: ReducedModel, name: str, requirements: Requirement | Sequence[Requirement]
) -> tuple[Requirement, ...]:
    wanted = (requirements,) if isinstance(requirements, Requirement) else tuple(sequence(name, requirements))
    for item in wanted:
        if not isinstance(cast("object", item), Requirement):
            raise ProblemError(f"{name}: {shown(item)} is not a requirement")
        check_names(reduced.scene, item)
    return wanted

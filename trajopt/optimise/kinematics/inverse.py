"""Inverse kinematics: configurations that hold a goal, nearest first, or the reason why there are none."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from trajopt.geometry import evaluator
from trajopt.optimise.kinematics.arguments import count_of, requirements_of
from trajopt.optimise.kinematics.goal_candidates import (
    LEVENBERG_MARQUARDT,
    STARTS,
    InverseMethod,
    goal_candidates,
    inverse_method,
)
from trajopt.optimise.kinematics.validity import Validity, validity
from trajopt.problem.requirements import Requirement
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value, floats, readonly
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True, eq=False)
class InverseSolutions(Value):
    """Result of inverse kinematics.

    Attributes:
        free: Configurations that hold the goal and touch nothing, shape (n,) each, nearest first.
        colliding: Configurations that hold the goal but collide, nearest first.
        nearest: If none is free: faults of the nearest that collides, or else of the
            configuration that came nearest to the goal.
    """

    free: tuple[Floats, ...]
    colliding: tuple[Floats, ...]
    nearest: Validity | None

    @property
    def valid(self) -> bool:
        """Whether the goal can be held without collision, as far as was found."""
        return bool(self.free)

    def explain(self) -> str:
        """Return the number of solutions, or how near the search came and the obstacle in the way."""
        if self.nearest is None:
            return f"{len(self.free)} free and {len(self.colliding)} colliding configurations found"
        why = "; ".join(self.nearest.reasons)
        if self.colliding:
            return (
                f"all {len(self.colliding)} configurations that hold the goal collide; in the nearest {why}"
            )
        return f"no configuration found that holds the goal; in the nearest {why}"


@checked
def inverse_kinematics(
    reduced: ReducedModel,
    goal: Requirement | Sequence[Requirement],
    *,
    near: ArrayLike | None = None,
    rng: np.random.Generator | None = None,
    starts: int = STARTS,
    method: str | InverseMethod = LEVENBERG_MARQUARDT.name,
) -> InverseSolutions:
    """Search configurations within limits that hold a goal: `frame_placement(...)` or any other.

    The frame may be a link, a tool frame or an attached object; tolerances are the requirement's, per axis.
    Several requirements hold together: `[frame_placement(...), joint_positions({"joint7": 0.5})]`
    finds solutions with the redundant joint at that value. See `docs/decisions/goal-configurations.md`.

    Args:
        reduced: The robot with its group's joints free, in its scene.
        goal: One requirement or several.
        near: Configuration of the group to be near, shape (n,); the start of the reduced model when None.
            Distance is the time of the slowest joint at full speed.
        rng: Draws the starts of the search; a fixed seed when None.
        starts: Number of starts of a wave; more find more solutions.
        method: Search method: "levenberg-marquardt", which takes every requirement, "placo", or your own
            method. Its answers are always checked.

    Raises:
        ProblemError: If no goal is given.
        NameNotFound: If the goal names an unknown frame or joint.
        ShapeError: If `near` is not one finite position for each joint.
        SolverNotFound: If the method's name is unknown.
        RequirementNotSupported: If the method cannot state a requirement.
    """
    chosen = inverse_method(method)
    wanted = requirements_of(reduced, "goal", goal)
    if not wanted:
        raise ProblemError("inverse_kinematics needs a goal: frame_placement(...) or several requirements")
    at = reduced if near is None else with_start(reduced, near, "near")
    found = goal_candidates(
        evaluator(at),
        wanted,
        rng=rng or np.random.default_rng(0),
        starts=count_of("starts", starts),
        method=chosen,
    )
    nearest: Validity | None = None
    if not found.free:
        nearest = validity(at, found.blocked[0] if found.blocked else found.nearest, requirements=wanted)
    return InverseSolutions(found.free, found.blocked, nearest)


def with_start(reduced: ReducedModel, positions: ArrayLike, name: str = "positions") -> ReducedModel:
    """Return the model with another start of the group's joints; all others stay in place.

    Args:
        reduced: The model.
        positions: Of the group's joints, shape (n,) [rad | m].
        name: Name of the positions in errors.

    Raises:
        ShapeError: If there is not one finite position for each joint of the group.
    """
    place = floats(name, positions, (len(reduced.joint_names),))
    return replace(reduced, start=readonly(reduced.all_positions(place)))

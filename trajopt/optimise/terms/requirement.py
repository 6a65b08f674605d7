"""From what is required (plain data) to constraints: each term's module registers its own."""

from functools import singledispatch

from trajopt.problem.requirements import Requirement
from trajopt.problem.requirements.registered import registered
from trajopt.problem.residual import Constraint, Window
from trajopt.scene.reduced import ReducedModel

INSET = 0.1
"""Share of a tolerance that the program keeps in reserve: the judge measures the timed motion, which
rounds the corners of the path, against the whole tolerance."""


@singledispatch
def constrain(
    required: Requirement, reduced: ReducedModel, window: Window, inset: float = INSET
) -> tuple[Constraint, ...]:
    """Return the constraints that make a motion hold a requirement.

    Args:
        required: What is required.
        reduced: The robot and its surroundings.
        window: Where it must hold.
        inset: Share of each tolerance to keep in reserve.

    Raises:
        ProblemError: If no term is registered for this kind of requirement.
    """
    return registered(constrain, type(required), "term")(required, reduced, window, inset)

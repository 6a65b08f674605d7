"""Dispatch from a requirement to the numbers that it bounds."""

from functools import singledispatch

from trajopt.errors import ProblemError
from trajopt.model.requirements import Requirement
from trajopt.verify.checks.quantity import Quantity
from trajopt.verify.kernel.motion import Motion


@singledispatch
def quantities(requirement: Requirement, motion: Motion) -> tuple[Quantity, ...]:
    """Return the numbers that a requirement bounds, along a motion.

    Raises:
        ProblemError: If the class has registered none.
        NameNotFound: If the requirement names what does not exist.
    """
    raise ProblemError(f"no numbers are registered for requirements of type {type(requirement).__name__}")

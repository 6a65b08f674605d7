"""Argument validation: counts, frames and requirements."""

from collections.abc import Sequence
from typing import cast

from trajopt.problem.requirements import Requirement
from trajopt.problem.stated import check_names
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import one_of, sequence
from trajopt.values.errors import ProblemError, ShapeError, shown


def count_of(name: str, value: int) -> int:
    """Return an integer of at least 1.

    Raises:
        ProblemError: If it is not an integer.
        ShapeError: If it is smaller.
    """
    if one_of(name, value, int) < 1:
        raise ShapeError(name, f"must be at least 1, is {value}")
    return value


def frame_of(reduced: ReducedModel, name: str) -> str:
    """Return the name of an existing frame.

    Raises:
        FrameNotFound: If it is not.
        ProblemError: If it is not a name.
    """
    reduced.attachment(one_of("frame", name, str))
    return name


def requirements_of(
    reduced: ReducedModel, name: str, requirements: Requirement | Sequence[Requirement]
) -> tuple[Requirement, ...]:
    wanted = (requirements,) if isinstance(requirements, Requirement) else tuple(sequence(name, requirements))
    for item in wanted:
        if not isinstance(cast("object", item), Requirement):
            raise ProblemError(f"{name}: {shown(item)} is not a requirement")
        check_names(reduced.scene, item)
    return wanted

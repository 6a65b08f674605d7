"""The one exception of the commander: every misuse leaves it as this, with the names that exist."""

from collections.abc import Callable
from functools import wraps
from inspect import getmembers_static, isfunction
from typing import ParamSpec, TypeVar

from trajopt.values.errors import NameNotFound, TrajoptError, shown

P = ParamSpec("P")
R = TypeVar("R")
C = TypeVar("C", bound=type)


class MoveItCommanderException(TrajoptError):
    """Something was asked that cannot be asked; the message names the offender."""


class NoStandIn(MoveItCommanderException, AttributeError):
    """A name of ROS or MoveIt that a script uses cannot be stood in for."""


def full_message(error: TrajoptError) -> str:
    """Return the sentence of an error; of an unknown name, with all names that exist."""
    if not isinstance(error, NameNotFound):
        return str(error)
    near = f" (did you mean {shown(error.near[0])}?)" if error.near else ""
    there = ", ".join(error.known) or "none"
    return f"no {error.kind} named {shown(error.name)}{near}; there are: {there}"


def as_moveit(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function with trajopt's errors raised as MoveIt's; the original is the `__cause__`."""

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except MoveItCommanderException:
            raise
        except TrajoptError as error:
            raise MoveItCommanderException(full_message(error)) from error

    return call


def speaks_moveit(cls: C) -> C:
    """Let every public method of a class, inherited or not, and its constructor raise MoveIt's exception."""
    for name, function in getmembers_static(cls, isfunction):
        if name == "__init__" or not name.startswith("_"):
            setattr(cls, name, as_moveit(function))
    return cls

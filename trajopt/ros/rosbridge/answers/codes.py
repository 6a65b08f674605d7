"""MoveIt's error codes of what cannot be done: which name is unknown, which part of a request is wrong."""

from collections.abc import Sequence
from dataclasses import replace

from trajopt.files.messages.moveit_msgs import MoveItErrorCodes
from trajopt.values.errors import (
    FrameNotFound,
    GroupNotFound,
    NameNotFound,
    ObjectNotFound,
    TrajoptError,
)

SOURCE = "trajopt"
"""Who says so."""
BY_PART = {
    "goal_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "path_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "trajectory_constraints": MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS,
    "start_state": MoveItErrorCodes.INVALID_ROBOT_STATE,
    "robot_state": MoveItErrorCodes.INVALID_ROBOT_STATE,
}
"""The code of what is wrong in a part of a request; MoveIt has one code for all constraints."""


def success(message: str = "") -> MoveItErrorCodes:
    """Return the code of what was done, with a remark."""
    return MoveItErrorCodes(MoveItErrorCodes.SUCCESS, message, SOURCE)


def with_notes(code: MoveItErrorCodes, notes: Sequence[str]) -> MoveItErrorCodes:
    """Return a code whose message says too what was taken differently from how it was asked, or left out."""
    return replace(code, message="; ".join(each for each in (code.message, *notes) if each))


def failed(code: int, reason: str) -> MoveItErrorCodes:
    """Return the code of what was not done, with the reason."""
    return MoveItErrorCodes(code, reason, SOURCE)


def code_of_error(error: TrajoptError) -> MoveItErrorCodes:
    """Return the code of a request that names what does not exist, or cannot be read.

    A group, a link, an object and a frame have codes of their own; other names, and what is malformed, have
    that of the part of the request.
    """
    return failed(_code(error), str(error))


def _code(error: TrajoptError) -> int:
    if isinstance(error, GroupNotFound):
        return MoveItErrorCodes.INVALID_GROUP_NAME
    if isinstance(error, ObjectNotFound):
        return MoveItErrorCodes.INVALID_OBJECT_NAME
    if isinstance(error, FrameNotFound):
        header = "header" in error.kind
        return MoveItErrorCodes.FRAME_TRANSFORM_FAILURE if header else MoveItErrorCodes.INVALID_LINK_NAME
    where = error.kind if isinstance(error, NameNotFound) else str(error)
    return next((code for part, code in BY_PART.items() if part in where), MoveItErrorCodes.FAILURE)

"""Errors of misuse: typed, naming the offender and likely alternatives.

Each class also derives from the builtin exception that it refines.
"""

import sys
import warnings
from collections.abc import Container, Iterable, Mapping, Sequence
from difflib import get_close_matches
from reprlib import Repr
from typing import Any

OPENGL_PACKAGES = "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6, and MUJOCO_GL=osmesa)"
"""OpenGL packages for Debian or Ubuntu without a graphics card."""


class TrajoptError(Exception):
    """Base class of all errors of trajopt."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), self.args), self.__dict__


def _restored(kind: type[TrajoptError], message: tuple[object, ...]) -> TrajoptError:
    return kind.__new__(kind, *message)


class ModelError(TrajoptError, ValueError):
    """A robot, scene or shape is invalid."""


class ProblemError(TrajoptError, ValueError):
    """A planning problem or one of its parts is malformed."""


class SolverError(TrajoptError, RuntimeError):
    """A solver or one of its backends cannot be used."""


class ExecutionError(TrajoptError, RuntimeError):
    """A driver of a robot cannot be used, or cannot do its task."""


class ClockError(ProblemError):
    """A time stamp is ahead of the clock that it refers to."""


class CampaignError(TrajoptError, RuntimeError):
    """A campaign cannot continue, or its folder is damaged."""


OTHER_ARGUMENTS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(
        ("timeout", "time_limit", "max_time", "planning_time", "allowed_planning_time"), ("seconds", "budget")
    ),
    **dict.fromkeys(("quat", "xyzw", "orientation", "rotation_quaternion"), ("quaternion",)),
    **dict.fromkeys(("euler", "angles"), ("rpy",)),
    **dict.fromkeys(("pos", "position", "translation", "origin"), ("xyz", "placement")),
    **dict.fromkeys(("pose", "transform"), ("placement",)),
    **dict.fromkeys(("planner", "planner_id", "solver", "optimizer"), ("method",)),
    **dict.fromkeys(("seed", "initial_guess", "init"), ("seeds", "rng")),
    **dict.fromkeys(("link", "frame_name", "tip"), ("frame",)),
}
"""Argument names of other libraries -> names here; the first that a function has is suggested."""


class UnknownArgument(ProblemError, TypeError):
    """A function has no argument of that name; the message suggests one, or lists all."""

    def __init__(self, called: str, name: str, known: Sequence[str], option: str = "") -> None:
        """Find the most likely argument; `option` shows how an option of this name is given."""
        self.name, self.known = name, tuple(known)
        usual = [other for other in OTHER_ARGUMENTS.get(name, ()) if other in known]
        near = usual or ([option] if option else get_close_matches(name, known, n=1))
        meant = f"did you mean {near[0]}?" if near else f"it has {', '.join(known)}"
        super().__init__(f"{called} has no argument {name}: {meant}")


class NameNotFound(ModelError, KeyError):
    """A name is unknown; carries similar known names.

    Attributes:
        near: The most similar known names, best first.
    """

    def __init__(
        self,
        kind: str,
        name: str,
        known: Iterable[str],
        *,
        left_out: str = "",
        objects: Iterable[str] = (),
        frames: Container[str] = (),
    ) -> None:
        """Find the near matches of a name among the known ones.

        Args:
            left_out: The reason why an entry of this name in a file was skipped.
            objects: Objects that would be valid too; the nearest is named if it is nearer than all known
                names.
            frames: Frames that are not valid here, one of which the name may mean.
        """
        self.kind, self.name = kind, name
        names, word = sorted(known), shown(name).strip("'")
        self.known: Sequence[str] = (*names, *objects)
        # Short words share two letters with anything: where nothing is nearer, all that is known says more.
        some = get_close_matches(word, [*names, *objects], n=1, cutoff=0.5)
        near = get_close_matches(word, names, n=3, cutoff=0.4) if some else []
        nearest = get_close_matches(word, [*near[:1], *objects], n=1, cutoff=0.4) if some else []
        self.near: Sequence[str] = tuple(near if nearest == near[:1] else [*nearest, *near[:2]])
        if left_out:
            hint = f"it was left out: {left_out}"
        elif name in frames:
            hint = "it is a frame of the robot"
        elif self.near:
            hint = "did you mean " + " or ".join(map(shown, self.near)) + "?"
        else:
            hint = f"known: {listed(names)}" if names else "there are none"
        self.message = f"no {kind} named {shown(name)}; {hint}"
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message


class FrameNotFound(NameNotFound):
    """No link, tool frame or scene object of that name."""


class JointNotFound(NameNotFound):
    """No movable joint of that name."""


class GroupNotFound(NameNotFound):
    """No planning group of that name."""


class StateNotFound(NameNotFound):
    """No named state of that name in the group."""


class ObjectNotFound(NameNotFound):
    """No scene object of that id."""


class RobotNotFound(NameNotFound):
    """No installed robot of that name and no URDF file at that path."""


class ProblemNotFound(NameNotFound):
    """No installed problem of that name."""


class WaypointNotFound(NameNotFound):
    """No waypoint of that name in the problem."""


class MessageNotFound(NameNotFound):
    """No ROS message of that name."""


class EntryNotFound(NameNotFound):
    """No entry of that name in the warehouse."""


class DuplicateObject(ModelError):
    """A scene object of that id already exists."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(f"the scene already has an object {shown(name)}; remove or move it instead")


class MimicCycle(ModelError):
    """Joints mimic each other in a cycle."""

    def __init__(self, joints: Sequence[str]) -> None:
        self.joints = tuple(joints)
        circle = ", which mimics ".join(map(shown, (*self.joints, self.joints[0])))
        super().__init__(f"joints mimic each other in a circle, and none leads: {circle}")


class MimicContradiction(ModelError):
    """A mimic joint has another position than its source joint implies.

    Attributes:
        position: Its given position [rad | m].
        expected: Its implied position [rad | m].
    """

    def __init__(self, joint: str, source: str, *, position: float, expected: float) -> None:
        self.joint, self.source, self.position, self.expected = joint, source, position, expected
        super().__init__(
            f"{joint} is put at {position:g}, but it follows {source} to {expected:g}; give {source} instead"
        )


class MimicOutOfRange(ModelError):
    """No position of a joint satisfies its own limits and the limits of the joints that follow it."""

    def __init__(self, joint: str, source: str, why: str) -> None:
        self.joint, self.source = joint, source
        super().__init__(f"{joint}, which follows {source}, {why}")


class ShapeError(ModelError):
    """An array has the wrong shape, or an invalid entry."""

    def __init__(self, name: str, problem: str) -> None:
        self.name = name
        super().__init__(f"{name}: {problem}")


class SizeError(ShapeError):
    """A length is not positive, or is likely in millimetres."""


class MeshFileError(ModelError):
    """A mesh file is missing, empty or unreadable."""

    def __init__(self, path: str, reason: str) -> None:
        self.path, self.reason = path, reason
        super().__init__(f"mesh file {end_of(path)}: {reason}")


class GripperError(ModelError):
    """A robot description lacks information about a gripper."""

    def __init__(self, robot: str, reason: str) -> None:
        self.robot, self.reason = robot, reason
        super().__init__(
            f"the gripper of robot {shown(robot)} is not known: {reason}; "
            "or describe it with trajopt.tasks.grasping.Gripper(...)"
        )


class FileFormatError(ModelError):
    """A file (URDF, SRDF, YAML, JSON) has invalid content."""

    def __init__(self, path: str, reason: str) -> None:
        self.path, self.reason = path, reason
        super().__init__(f"{end_of(path)}: {reason}")


class UnsupportedJoint(ModelError):
    """A joint has more than one degree of freedom."""

    def __init__(
        self,
        name: str,
        joint_type: str,
        remedy: str = "write it as a chain of prismatic, revolute and continuous joints, "
        "one degree of freedom each",
    ) -> None:
        self.name = name
        super().__init__(f"joint {shown(name)} is of type {shown(joint_type)}; {remedy}")


class SolverNotFound(NameNotFound, SolverError):
    """No solver, QP backend or method of inverse kinematics of that name."""


class RequirementNotSupported(SolverError):
    """A method of inverse kinematics cannot express a requirement."""

    def __init__(self, method: str, requirement: object, reason: str) -> None:
        self.method, self.requirement = method, requirement
        super().__init__(f"{method} cannot state {requirement}: {reason}")


class BackendFailed(SolverError):
    """A backend raised an error of its own; the original is the `__cause__`."""


class NativeCoresMissing(TrajoptError, ImportError):
    """The compiled parts of trajopt are missing, or were compiled for another Python."""

    def __init__(self, cores: Sequence[str]) -> None:
        self.cores = tuple(cores)
        super().__init__(
            f"trajopt's native cores ({', '.join(cores)}) are not compiled for this Python; install a wheel "
            "(pip install trajopt-planner), or compile a checkout with a C++17 compiler (pip install -e .)"
        )


class MissingExtra(TrajoptError, ImportError):
    """An optional package is not installed; the message contains the command that installs it."""

    def __init__(self, package: str, extra: str) -> None:
        self.package, self.extra = package, extra
        super().__init__(f'{package} is not installed; run: pip install "trajopt-planner[{extra}]"')


class RenderingUnavailable(TrajoptError, RuntimeError):
    """No OpenGL implementation was found; the message lists the attempts and the packages to install."""

    def __init__(self, tried: Sequence[str]) -> None:
        self.tried = tuple(tried)
        super().__init__(
            "no OpenGL to draw with: " + ("; ".join(tried) or "nothing found") + f". Try: {OPENGL_PACKAGES}"
        )


class PlanningFailed(TrajoptError):
    """Raised by `Result.require` when there is no verified plan; carries the result."""

    def __init__(self, message: str, result: object) -> None:
        self.result = result
        super().__init__(message)


class UnitWarning(UserWarning):
    """A number is accepted although another unit is likely: degrees for radians, mm for m."""


def warn_of_unit(words: str) -> None:
    level, frame = 2, sys._getframe(1)  # pyright: ignore[reportPrivateUsage]
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "trajopt":
        level, frame = level + 1, frame.f_back
    warnings.warn(words, UnitWarning, stacklevel=level)


LISTED = 12


def listed(names: Sequence[str]) -> str:
    """Return names for a message; only the first ones if there are many."""
    return ", ".join(end_of(name) for name in names[:LISTED]) + (", ..." if len(names) > LISTED else "")


SHOWN_LENGTH = 80
VECTOR = 8
"""Largest vector that is written out in a message."""


class _Short(Repr):
    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxtuple = self.maxlist = self.maxdict = self.maxset = self.maxfrozenset = self.maxarray = 4
        self.maxstring = self.maxother = self.maxlong = SHOWN_LENGTH

    def repr_int(self, x: int, level: int) -> str:
        return repr(x) if x.bit_length() < 200 else f"a whole number of {x.bit_length()} bits"

    def repr_ndarray(self, x: Any, level: int) -> str:
        if x.ndim == 1 and x.size <= VECTOR and x.dtype.kind == "f":
            return "[" + ", ".join(f"{value:.4g}" for value in x.tolist()) + "]"
        return f"array of shape {x.shape}"

    def repr_bytes(self, x: bytes, level: int) -> str:
        return repr(x[:SHOWN_LENGTH])


def shown(value: object) -> str:
    """Return the repr of a value, however large, deep or recursive, in at most `SHOWN_LENGTH` characters."""
    text = _Short().repr(value)
    return text if len(text) <= SHOWN_LENGTH else f"{text[: SHOWN_LENGTH - 3]}..."


PATH_LENGTH = 200


def end_of(path: str) -> str:
    return path if len(path) <= PATH_LENGTH else f"...{path[3 - PATH_LENGTH :]}"


def unknown_attribute(owner: object, name: str, other_names: Mapping[str, str]) -> AttributeError:
    """Return the error of an unknown attribute, with the expression for a name of another library."""
    words = f"{type(owner).__name__!r} object has no attribute {name!r}"
    hint = other_names.get(name)
    return AttributeError(f"{words}: use {hint}" if hint else words, name=name, obj=owner)


def kind_words(kind: type[object]) -> str:
    if kind is str:
        return "a name"
    module = "" if kind.__module__.startswith(("trajopt", "builtins")) else kind.__module__
    name = ".".join(part for part in (*module.split("."), kind.__name__) if part and part[0] != "_")
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"

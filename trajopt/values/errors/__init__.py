"""Errors of misuse: typed, naming the offender and what it may have meant.

Not finding a plan is no error: it is a `Status`. These are raised for input that is not a valid
problem at all. Each class also derives from the builtin exception that it refines. `UnitWarning` is for
numbers that are taken as they are, though another unit is likely.
"""

import sys
import warnings
from collections.abc import Container, Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from trajopt.values.errors.shown import end_of as end_of
from trajopt.values.errors.shown import listed as listed
from trajopt.values.errors.shown import shown as shown

OPENGL_PACKAGES = "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6, and MUJOCO_GL=osmesa)"
"""Packages with OpenGL for a Debian or Ubuntu without a graphics card."""


class TrajoptError(Exception):
    """Root of every error that trajopt raises on purpose."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Restore it whole: by default exceptions are rebuilt from their message alone."""
        return _restored, (type(self), self.args), self.__dict__


def _restored(kind: type[TrajoptError], message: tuple[object, ...]) -> TrajoptError:
    return kind.__new__(kind, *message)


class ModelError(TrajoptError, ValueError):
    """A robot, scene or shape is not what it must be."""


class ProblemError(TrajoptError, ValueError):
    """A planning problem or one of its parts is malformed."""


class SolverError(TrajoptError, RuntimeError):
    """A solver or one of its backends cannot be used."""


class ExecutionError(TrajoptError, RuntimeError):
    """What drives a robot cannot be asked, or cannot do what it must."""


class ClockError(ProblemError):
    """A time stamp is ahead of the clock that it refers to."""


class CampaignError(TrajoptError, RuntimeError):
    """A campaign cannot go on, or its folder does not hold what it must."""


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
"""Names of arguments in other libraries, and what is meant here, the first of them that a function has."""


class UnknownArgument(ProblemError, TypeError):
    """A function has no argument of that name; the message names the one meant, or all that it has."""

    def __init__(self, called: str, name: str, known: Sequence[str]) -> None:
        """Find the argument that is meant.

        Args:
            called: The function.
            name: What was given.
            known: Its arguments.
        """
        self.name, self.known = name, tuple(known)
        usual = [other for other in OTHER_ARGUMENTS.get(name, ()) if other in known]
        near = usual or get_close_matches(name, known, n=1)
        meant = f"did you mean {near[0]}?" if near else f"it has {', '.join(known)}"
        super().__init__(f"{called} has no argument {name}: {meant}")


class NameNotFound(ModelError, KeyError):
    """A name is unknown; carries the known names that are similar.

    Attributes:
        kind: What was looked for ("link", "group", ...).
        name: The unknown name.
        near: The most similar known names, best first.
        known: All known names.
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
            kind: What was looked for.
            name: Its name.
            known: Names of what there is of the kind.
            left_out: Why a file's entry of this name is missing.
            objects: Objects that would do as well: one is named where it is nearer than all that is known.
            frames: Frames that would not do, of which this may be the name of one.
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
        """Return the sentence itself (KeyError would show its repr)."""
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
    """No message of ROS of that name."""


class EntryNotFound(NameNotFound):
    """Nothing of that name in the warehouse."""


class DuplicateObject(ModelError):
    """A scene object of that id is there already."""

    def __init__(self, name: str) -> None:
        """Name the id that is taken."""
        self.name = name
        super().__init__(f"the scene already has an object {shown(name)}; remove or move it instead")


class MimicCycle(ModelError):
    """Joints mimic each other in a circle, so that none leads.

    Attributes:
        joints: The joints, each mimicking the next, and the last the first.
    """

    def __init__(self, joints: Sequence[str]) -> None:
        """Name the joints of the circle."""
        self.joints = tuple(joints)
        circle = ", which mimics ".join(map(shown, (*self.joints, self.joints[0])))
        super().__init__(f"joints mimic each other in a circle, and none leads: {circle}")


class MimicContradiction(ModelError):
    """A mimic joint is put where it cannot be, given where the joint is that it follows.

    Attributes:
        joint: The mimic joint.
        source: The joint that it follows.
        position: Where it is put [rad | m].
        expected: Where it follows to [rad | m].
    """

    def __init__(self, joint: str, source: str, *, position: float, expected: float) -> None:
        """Name the joint, the one it follows, and both positions."""
        self.joint, self.source, self.position, self.expected = joint, source, position, expected
        super().__init__(
            f"{joint} is put at {position:g}, but it follows {source} to {expected:g}; give {source} instead"
        )


class MimicOutOfRange(ModelError):
    """No position of a joint holds its own position limits and those of the joints that follow it.

    Attributes:
        joint: The mimic joint whose limits cannot be held.
        source: The joint that it follows.
    """

    def __init__(self, joint: str, source: str, why: str) -> None:
        """Name the joint and the one it follows, and say why."""
        self.joint, self.source = joint, source
        super().__init__(f"{joint}, which follows {source}, {why}")


class ShapeError(ModelError):
    """An array has the wrong shape, or a number in it cannot be used.

    Attributes:
        name: The argument at fault.
    """

    def __init__(self, name: str, problem: str) -> None:
        """Say which argument is wrong and why."""
        self.name = name
        super().__init__(f"{name}: {problem}")


class SizeError(ShapeError):
    """A length is not positive, or so large that it must have been meant in millimetres."""


class MeshFileError(ModelError):
    """A mesh file is missing, empty or unreadable."""

    def __init__(self, path: str, reason: str) -> None:
        """Name the file and the reason."""
        self.path, self.reason = path, reason
        super().__init__(f"mesh file {end_of(path)}: {reason}")


class GripperError(ModelError):
    """The description of a robot does not say enough about a gripper."""

    def __init__(self, robot: str, reason: str) -> None:
        """Name the robot, what is missing, and the way out."""
        self.robot, self.reason = robot, reason
        super().__init__(
            f"robot {shown(robot)} has no gripper to grasp with: {reason}; "
            "describe one with trajopt.tasks.grasping.Gripper(...)"
        )


class FileFormatError(ModelError):
    """A file (URDF, SRDF, YAML, JSON) does not say what it must.

    Attributes:
        path: The file.
        reason: What is wrong, and where in the file.
    """

    def __init__(self, path: str, reason: str) -> None:
        """Name the file and what is wrong in it."""
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
        """Name the joint and what to do instead."""
        self.name = name
        super().__init__(f"joint {shown(name)} is of type {shown(joint_type)}; {remedy}")


class SolverNotFound(NameNotFound, SolverError):
    """No solver, QP backend or method of inverse kinematics of that name."""


class RequirementNotSupported(SolverError):
    """A method of inverse kinematics cannot express a requirement.

    Attributes:
        method: Name of the method.
        requirement: The requirement.
    """

    def __init__(self, method: str, requirement: object, reason: str) -> None:
        """Name the method and the requirement, and say what stands in the way."""
        self.method, self.requirement = method, requirement
        super().__init__(f"{method} cannot state {requirement}: {reason}")


class BackendFailed(SolverError):
    """A backend raised an error of its own; the original is the `__cause__`."""


class NativeCoresMissing(TrajoptError, ImportError):
    """The compiled parts of trajopt are not there, or were compiled for another Python.

    Attributes:
        cores: Names of those that are missing.
    """

    def __init__(self, cores: Sequence[str]) -> None:
        """Say how to get them."""
        self.cores = tuple(cores)
        super().__init__(
            f"trajopt's native cores ({', '.join(cores)}) are not compiled for this Python; install a wheel "
            "(pip install trajopt-planner), or compile a checkout with a C++17 compiler (pip install -e .)"
        )


class MissingExtra(TrajoptError, ImportError):
    """An optional package is not installed; the message holds the command that installs it."""

    def __init__(self, package: str, extra: str) -> None:
        """Name the package and the extra that brings it."""
        self.package, self.extra = package, extra
        super().__init__(f'{package} is not installed; run: pip install "trajopt-planner[{extra}]"')


class RenderingUnavailable(TrajoptError, RuntimeError):
    """No way to draw was found; the message says what was tried and what to install."""

    def __init__(self, tried: Sequence[str]) -> None:
        """Keep what was tried, each with the reason why it failed."""
        self.tried = tuple(tried)
        super().__init__(
            "no OpenGL to draw with: " + ("; ".join(tried) or "nothing found") + f". Try: {OPENGL_PACKAGES}"
        )


class PlanningFailed(TrajoptError):
    """Raised by `Result.require` when there is no verified plan; carries the result."""

    def __init__(self, message: str, result: object) -> None:
        """Keep the result beside its sentence."""
        self.result = result
        super().__init__(message)


class UnitWarning(UserWarning):
    """A number is taken as it is, though another unit is likely: degrees for radians, mm for m."""


def warn_of_unit(words: str) -> None:
    """Warn at the line outside of trajopt that the number comes from."""
    level, frame = 2, sys._getframe(1)  # pyright: ignore[reportPrivateUsage]
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "trajopt":
        level, frame = level + 1, frame.f_back
    warnings.warn(words, UnitWarning, stacklevel=level)

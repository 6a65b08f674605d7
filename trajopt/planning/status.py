"""Status and certainty of an outcome, and their summary in words."""

from dataclasses import dataclass
from enum import Enum

from trajopt.values.arrays import Value
from trajopt.values.printed import in_short


class Status(Enum):
    """Status at the end of planning; each value states its meaning and a remedy."""

    SOLVED = "the judge verified the motion"
    START_IN_COLLISION = (
        "the start is in collision, or nearer to something than is required: move it, or allow that"
    )
    CLEARANCE_IMPOSSIBLE = (
        "things are nearer in every configuration than is required of them: require less of them, by name or "
        "by kind"
    )
    START_OUT_OF_LIMITS = "the start is outside a joint limit: move it inside first"
    START_BREAKS_CONSTRAINT = "the start breaks a path constraint: widen it, or start elsewhere"
    START_TOO_FAST = (
        "the start moves so fast that it exceeds a limit, or something is met, however the joints brake: "
        "start slower, or farther away"
    )
    START_CANNOT_BE_HELD = (
        "a joint is too weak to hold the arm and what it carries still at the start: carry less, or start "
        "elsewhere"
    )
    GOAL_IN_COLLISION = (
        "no configuration found at the goal is free: all are in collision, or nearer to something than is "
        "required: move it, or allow that"
    )
    GOAL_OUT_OF_LIMITS = "the goal is outside a joint limit: choose another"
    GOAL_BREAKS_CONSTRAINT = (
        "no configuration found at the goal holds the path constraints: widen them, or choose another goal"
    )
    GOAL_CANNOT_BE_HELD = (
        "no configuration found at the goal lets every joint hold the arm and what it carries still: carry "
        "less, or choose a goal that needs less reach"
    )
    NO_INVERSE_KINEMATICS = (
        "no configuration found that reaches the goal: move it nearer or widen its tolerance"
    )
    CONFLICTING_CONSTRAINTS = (
        "no configuration found holds all goals and path constraints together, though any one fewer can be "
        "held: widen one of them"
    )
    NO_WAYPOINT = "no configuration found for a waypoint: move it or widen its tolerance"
    STUCK = (
        "the solver stopped where constraints do not hold: a local minimum, which another goal "
        "configuration, a smaller margin or waypoints may avoid"
    )
    PROVEN_INFEASIBLE = (
        "every path from the start to the goal is blocked: move what is in the way, or the goal"
    )
    TOO_LATE = "no motion is over by the deadline: allow more time, or start nearer to the goal"
    BLOCKED_IN_TIME = (
        "no later beginning and no way around was found that keeps clear of what moves, appears or expires: "
        "wait until it is gone, or move the goal"
    )
    INEVITABLE = (
        "something sweeps the start, and no motion within the limits escapes it: keep it away, start "
        "elsewhere, or let the arm be faster"
    )
    FIXED_LINK_MET = (
        "something meets a link that no joint of the group moves, before a motion is over: keep it away, let "
        "the two touch, or begin when it has passed"
    )
    GOAL_OCCUPIED = (
        "the goal is never free when the arm could be there: remove what occupies it, start later, or choose "
        "another goal"
    )
    NO_SEED = "no seed of that kind could be made: another kind may do"
    OUT_OF_TIME = "the time was used up before a motion was found: allow more, or try again"
    OUT_OF_WORK = "the counted work was used up before a motion was found: allow more"
    CANCELLED = "planning was cancelled before a motion was found"
    METHOD_CANNOT = "the method cannot do what is asked: choose another"
    COLLISION = (
        "the arm comes too near something along the curve: move it, free the spin, or allow a deviation"
    )
    JOINT_LIMIT = (
        "a joint reaches its limit on the curve: begin in another branch, free the spin, or move the curve"
    )
    OUT_OF_REACH = "the arm cannot reach the curve any farther: move the curve"
    BRANCH_JUMP = "the curve goes on in another branch only, to which a joint would have to jump: begin there"
    GRIPPER_CANNOT = "the gripper cannot grasp or release as stated"
    STAGE_LIMITS = "no way was found to do the stage within its limits: widen them"
    NO_TIMING = "no speed along the path keeps the limits: widen the one that is named"
    NOT_VERIFIED = "the judge refused the timed motion: a larger margin or more knots may help"


class Certainty(Enum):
    """How well a verdict is known."""

    PROVEN = "proven"
    EVIDENCE = "evidence, no proof"


@dataclass(frozen=True, eq=False, kw_only=True)
class OutcomeSummary(Value):
    """Outcome of planning and its reason: `print` it, or read its parts.

    Attributes:
        grounds: Proof of the verdict, or evidence for it.
        details: Particulars, one a line.
    """

    status: Status
    reason: str
    certainty: Certainty
    grounds: str
    details: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {
            "status": self.status.name,
            "reason": self.reason,
            "certainty": self.certainty.name,
            "grounds": self.grounds,
            "details": list(self.details),
        }

    def __repr__(self) -> str:
        return in_short(f"{type(self).__name__}({self.status.name}, {self.certainty.value}: {self.grounds})")

    def __str__(self) -> str:
        lines = [self.reason, f"This is {self.certainty.value}: {self.grounds}."]
        return "\n".join([*lines, *(f"  {line}" for line in self.details)])

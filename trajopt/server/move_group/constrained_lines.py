"""Lines under path constraints: followed as far as these are proven to hold."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from trajopt.planning.judgement import decide
from trajopt.planning.status import Status
from trajopt.problem.requirements import Requirement
from trajopt.tasks.cartesian import Followed
from trajopt.tasks.cartesian.result import StopReason
from trajopt.verify import Judge

HALVINGS = 6
"""How often the part of a line is halved on which constraints may or may not hold: 1/64 of it is left."""


def as_far_as_kept(
    followed: Followed, constraints: Sequence[Requirement], until: Callable[[float], Followed]
) -> Followed:
    """Return a motion along a line that keeps constraints all the way, as far as one is found.

    Args:
        followed: The motion without them.
        constraints: What must hold all the way.
        until: Follows the line as far as a length along it [m].
    """
    if not constraints or not followed.verified:
        return followed
    best, refused = None, _judged(followed, constraints)
    if refused.verified:
        return refused
    kept, broken = 0.0, followed.fraction * followed.required.until
    for _ in range(HALVINGS):
        middle = 0.5 * (kept + broken)
        part = until(middle)
        judged = _judged(part, constraints) if part.complete else part
        if judged.complete:
            best, kept = judged, middle
        else:
            broken, refused = middle, judged
    verdict = refused.certificate
    words = refused.reason if verdict is None else verdict.verdict
    whole = followed.required
    stop = StopReason(
        status=Status.NOT_VERIFIED,
        at=kept,
        pose=whole.curve.pose_before(kept),
        message=f"the path constraints are not kept beyond: {words}",
    )
    if best is None:
        result = replace(refused.result, status=Status.NOT_VERIFIED, message=stop.message)
        return replace(refused, required=whole, fraction=0.0, stop=stop, result=result)
    return replace(best, required=whole, fraction=kept / whole.until, stop=stop)


def _judged(followed: Followed, constraints: Sequence[Requirement]) -> Followed:
    """Return a motion with the verdict on whether it keeps constraints too."""
    trajectory = followed.trajectory
    assert trajectory is not None
    problem = replace(followed.problem, constraints=(*followed.problem.constraints, *constraints))
    verdict, _ = decide(problem, trajectory, Judge(problem.reduced))
    status = Status.SOLVED if verdict.verified else Status.NOT_VERIFIED
    return replace(followed, result=replace(followed.result, status=status, problem=problem, judged=verdict))

"""The deadline: a motion is at its goal by then."""

from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.motion import Motion


def deadline_checks(motion: Motion, finish_by: float | None, follows: float = 0.0) -> tuple[Check, ...]:
    """Judge whether a motion is at its goal in time; nothing where there is no deadline.

    Args:
        motion: The motion.
        finish_by: When it must be at the goal, its own start being at 0 [s].
        follows: How long it follows a goal that moves when it ends [s]: it is there before.
    """
    if finish_by is None:
        return ()
    there = motion.duration - follows
    slack = finish_by - there
    late = f"{-slack:.3f} s late" if slack < 0.0 else f"{slack:.3f} s early"
    return (
        Check(
            kind=CheckKind.DEADLINE,
            name="finish by",
            subject="",
            value=there,
            bound=finish_by,
            unit="s",
            time=there,
            slack=slack,
            evidence=Evidence.PROVEN,
            holds=slack >= 0.0,
            detail=f"is at the goal at {there:.3f} s, {late}",
        ),
    )

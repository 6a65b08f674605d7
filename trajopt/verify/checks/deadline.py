"""The deadline: a motion is over by then."""

from trajopt.verify.certificate import Check, CheckKind, Evidence
from trajopt.verify.kernel.motion import Motion


def deadline_checks(motion: Motion, finish_by: float | None) -> tuple[Check, ...]:
    """Judge whether a motion is over in time; nothing where there is no deadline.

    Args:
        motion: The motion.
        finish_by: When it must be over, its own start being at 0 [s].
    """
    if finish_by is None:
        return ()
    slack = finish_by - motion.duration
    late = f"{-slack:.3f} s late" if slack < 0.0 else f"{slack:.3f} s early"
    return (
        Check(
            kind=CheckKind.DEADLINE,
            name="finish by",
            subject="",
            value=motion.duration,
            bound=finish_by,
            unit="s",
            time=motion.duration,
            slack=slack,
            evidence=Evidence.PROVEN,
            holds=slack >= 0.0,
            detail=f"is over at {motion.duration:.3f} s, {late}",
        ),
    )

"""A result as a short text: what was asked, what holds and by how much, what it cost."""

from collections.abc import Sequence

from trajopt.planning.result import Result


def report(result: Result, notes: Sequence[str] = ()) -> str:
    """Return the report of a result.

    Args:
        result: What planning returned.
        notes: Sentences about how files were read.
    """
    lines = ["asked", *_indented(str(result.problem)), "", "answer", f"  {result.reason}"]
    trajectory, path = result.trajectory, result.path
    if trajectory is not None and path is not None and result.timed is not None:
        lines.append(
            f"  motion of {trajectory.duration:.3f} s in {len(trajectory.times)} points, path of "
            f"{path.length:.2f} rad, at most {result.timed.deviation * 1000:.1f} mm from the checked path"
        )
        decisive = ", ".join(f"{kind} {part:.0%}" for kind, part in result.timed.binding.items())
        lines.append(f"  as fast as its limits allow: {decisive or 'none decides'} of the time")
    if result.certificate is not None:
        lines += ["", "certificate", *_indented(str(result.certificate))]
    if notes:
        lines += ["", "notes on the files", *(f"  {note}" for note in notes)]
    return "\n".join([*lines, "", "cost", *_indented(cost(result))])


def cost(result: Result) -> str:
    """Return CPU time by stage and the counts."""
    stages = ", ".join(f"{name} {1000 * used:.0f}" for name, used in result.cpu_seconds.items())
    total = 1000 * sum(result.cpu_seconds.values())
    counts = ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in result.counts.items())
    return f"CPU {total:.0f} ms ({stages})\n{counts}"


def _indented(text: str) -> list[str]:
    return [f"  {line}".rstrip() for line in text.splitlines()]

"""Replay: a bundle's problem planned anew, and what differs from what was answered then."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from trajopt.files.bundle.bundle import Bundle
from trajopt.files.bundle.writing import versions
from trajopt.optimise.methods import Method
from trajopt.planning.plan import plan
from trajopt.planning.plan_arguments import PlanArguments
from trajopt.planning.result import Result
from trajopt.values.arrays import Value
from trajopt.values.errors import ModelError
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True, eq=False)
class Replay(Value):
    """What planning answers now, beside what it answered then.

    Attributes:
        bundle: What was asked and answered then.
        result: What is answered now.
        differences: What differs, in sentences; none where the answers are the same to the last digit.
    """

    bundle: Bundle
    result: Result
    differences: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.differences

    def as_dict(self) -> dict[str, Any]:
        """Return plain data that JSON can hold."""
        return {
            "same": self.same,
            "differences": list(self.differences),
            "then": {"status": self.bundle.status, "versions": dict(self.bundle.versions)},
            "now": {"status": self.result.status.name, "versions": dict(versions())},
        }

    def __str__(self) -> str:
        """Say that the answer is the same, or what differs."""
        if self.same:
            return f"{self.bundle.path.name}: the same answer, to the last digit: {self.result.reason}"
        return "\n".join((f"{self.bundle.path.name}: another answer", *(f"  {e}" for e in self.differences)))


@checked
def replay(bundle: Bundle, *, method: Method | str | None = None) -> Replay:
    """Plan a bundle's problem anew, as it was asked then, and compare the answers.

    Args:
        bundle: The bundle.
        method: As `plan` takes it; as it was asked then when None. Methods with options of their own are
            no data: give such a one again.

    Raises:
        ModelError: If the bundle was planned by a method with options of its own, and none is given.
    """
    arguments = bundle.arguments or PlanArguments()
    if bundle.custom_method and method is None:
        raise ModelError(
            f"{bundle.path} was planned by {bundle.method or 'a method'} with options of its own, which "
            "no file holds; give it: replay(bundle, method=...)"
        )
    result = plan(
        bundle.problem,
        method=arguments.method if method is None else method,
        improve=arguments.improve,
        every_goal=arguments.every_goal,
        seeds=arguments.seeds,
        budget=arguments.budget,
        rng=arguments.generator,
    )
    return Replay(bundle, result, tuple(_differences(bundle, result, arguments)))


def _differences(bundle: Bundle, result: Result, arguments: PlanArguments) -> list[str]:
    """Return what differs, in sentences: the answer first, then what may be the cause."""
    found = list[str]()
    if bundle.status and bundle.status != result.status.name:
        found.append(f"status: {bundle.status} then, {result.status.name} now ({result.reason})")
    found += _motions(bundle, result)
    counts = bundle.answer.get("counts")
    if counts is not None and counts != dict(result.counts):
        found.append("the work done, in exact counts, is not the same")
    if not found:
        return found
    if not arguments.repeatable:
        found.append("planning was bounded by a clock, so it may end differently each time")
    now = versions()
    changed = [
        f"{name} {then} then, {now.get(name, 'unknown')} now" for name, then in bundle.versions.items()
    ]
    changed = [
        words
        for words, name in zip(changed, bundle.versions, strict=True)
        if bundle.versions[name] != now.get(name)
    ]
    return found + [f"versions: {', '.join(changed)}"] * bool(changed)


def _motions(bundle: Bundle, result: Result) -> list[str]:
    """Say how the motions differ."""
    then, now = bundle.trajectory, result.trajectory
    if then is None or now is None:
        if then is now:
            return []
        return [f"motion: {'none' if then is None else 'one'} then, {'none' if now is None else 'one'} now"]
    if then.times.shape == now.times.shape and all(
        np.array_equal(getattr(then, name), getattr(now, name))
        for name in ("times", "positions", "velocities", "accelerations")
    ):
        return []
    duration = f"{then.duration:.6f} s then, {now.duration:.6f} s now"
    shares = np.linspace(0.0, 1.0, 101)
    apart = np.abs(then(shares * then.duration) - now(shares * now.duration)).max()
    return [f"motion: {duration}; at equal shares of it joints are up to {apart:.3g} apart"]

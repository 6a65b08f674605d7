"""Replay: plan the problem of a bundle again and compare the results."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from trajopt.files.bundle.bundle import Bundle, versions
from trajopt.optimise.methods import Method
from trajopt.planning.plan import plan
from trajopt.planning.result import PlanArguments, Result
from trajopt.values.arrays import Value
from trajopt.values.errors import ModelError
from trajopt.values.errors.arguments import checked


@dataclass(frozen=True, eq=False)
class Replay(Value):
    """The new result of planning a bundle's problem, compared with the stored result."""

    bundle: Bundle
    result: Result
    differences: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether nothing differs."""
        return not self.differences

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "same": self.same,
            "differences": list(self.differences),
            "then": {"status": self.bundle.status, "versions": dict(self.bundle.versions)},
            "now": {"status": self.result.status.name, "versions": dict(versions())},
        }

    def __str__(self) -> str:
        if self.same:
            return f"{self.bundle.path.name}: the same answer, to the last digit: {self.result.reason}"
        return "\n".join((f"{self.bundle.path.name}: another answer", *(f"  {e}" for e in self.differences)))


@checked
def replay(bundle: Bundle, *, method: Method | str | None = None) -> Replay:
    """Plan a bundle's problem again with the stored arguments, and compare the results.

    Raises:
        ModelError: If the bundle was planned by a method with its own options, which must be passed again.
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
        f"{name} {then} then, {now.get(name, 'unknown')} now"
        for name, then in bundle.versions.items()
        if then != now.get(name)
    ]
    return found + [f"versions: {', '.join(changed)}"] * bool(changed)


def _motions(bundle: Bundle, result: Result) -> list[str]:
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

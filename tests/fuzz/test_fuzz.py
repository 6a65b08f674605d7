"""Random problems, sound and unsound: no crash, no false success, always a reason."""

from collections import Counter

import numpy as np
import pytest

import trajopt as to
from tests.fuzz.dense_check import first_contact
from tests.fuzz.scenarios import Kind, Scenario, scenario
from trajopt.planning import Plan
from trajopt.values.errors import PlanningFailed

QUICK, ALL, CHUNK = 100, 2000, 100
QUICK_STEP, STEP = 5e-3, 1e-3
"""How far a point moves between two looks of the dense check [m]."""
SOLVED_SHARE = 0.95
"""Of the problems for which a motion is known."""
MOST_ATTEMPTS = 200
"""First guesses of one problem at most; beyond it a run counts as hung."""


def outcome(asked: Scenario, step: float) -> str:
    """Plan one problem, check what comes out, and return how it ended."""
    if asked.kind is Kind.NONSENSE:
        with pytest.raises(to.TrajoptError) as caught:
            to.plan(asked.make())
        assert str(caught.value).strip(), "an error without words"
        return "refused"
    result = to.plan(asked.make())
    assert result.counts.get("attempts", 0) <= MOST_ATTEMPTS
    if not result.verified:
        assert result.message.strip(), f"{result.status.name} without a reason"
        with pytest.raises(PlanningFailed):
            result.require()
        return result.status.name
    plan = result.require()
    sound(plan)
    assert first_contact(asked.arm, plan, step=step) == "", f"number {asked.number} touches"
    return "SOLVED"


def sound(plan: Plan) -> None:
    """Assert what any motion must be: finite, from start to goal, within the limits of its joints."""
    problem, motion = plan.problem, plan.trajectory
    limits, times = problem.limits, np.linspace(0.0, motion.duration, 500)
    for order, (low, high) in enumerate(
        ((limits.lower, limits.upper), (-limits.velocity, limits.velocity),
         (-limits.acceleration, limits.acceleration))
    ):  # fmt: skip
        values = motion(times, order)
        assert np.isfinite(values).all()
        slack = 1e-6 * (1.0 + np.abs(values).max())
        assert (values >= low - slack).all() and (values <= high + slack).all(), f"order {order}"
    assert motion(0.0) == pytest.approx(problem.reduced.start_positions, abs=1e-6)


def run(numbers: range, step: float) -> Counter[tuple[Kind, str]]:
    seen: Counter[tuple[Kind, str]] = Counter()
    for number in numbers:
        asked = scenario(number)
        seen[asked.kind, outcome(asked, step)] += 1
    return seen


def solved_share(seen: Counter[tuple[Kind, str]]) -> tuple[int, int]:
    known = sum(count for (kind, _), count in seen.items() if kind is Kind.FEASIBLE)
    return seen[Kind.FEASIBLE, "SOLVED"], known


@pytest.mark.parametrize("first", range(0, QUICK, 25))
def test_some_random_problems(first: int) -> None:
    solved, known = solved_share(run(range(first, first + 25), QUICK_STEP))
    assert known >= 10
    assert solved >= known - 1


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("first", range(0, ALL, CHUNK))
def test_all_random_problems(first: int) -> None:
    """Of every hundred at least 95 % of those with a known motion are solved, so of all of them too."""
    solved, known = solved_share(run(range(first, first + CHUNK), STEP))
    assert known >= CHUNK / 2
    assert solved >= SOLVED_SHARE * known


def test_the_same_number_reproduces_a_problem() -> None:
    for number in range(4):
        one, other = (scenario(number) for _ in range(2))
        assert (one.kind, one.arm) == (other.kind, other.arm)
        if one.kind is not Kind.NONSENSE:
            assert one.make().start_positions == pytest.approx(other.make().start_positions)


def test_the_dense_check_sees_a_contact() -> None:
    """The straight line of a problem that could only be solved around something."""
    seen = 0
    for number in range(40):
        asked = scenario(number)
        if asked.kind is Kind.NONSENSE:
            continue
        result = to.plan(asked.make())
        if not result.verified:
            continue
        plan = result.require()
        ends = np.stack((plan.trajectory(0.0), plan.trajectory(plan.trajectory.duration)))
        still = np.zeros_like(ends)
        line = to.Trajectory(plan.trajectory.joint_names, np.array((0.0, 9.0)), ends, still, still)
        straight = Plan(plan.problem, plan.path, line, plan.judged)
        touches = first_contact(asked.arm, straight, step=QUICK_STEP)
        clear = to.judge(plan.problem, line)
        collides = any(check.name.startswith("clearance") for check in clear.failed)
        if touches:
            seen += 1
            assert collides, f"number {number}: the judge does not see that {touches}"
    assert seen >= 2

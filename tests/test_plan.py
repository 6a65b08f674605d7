"""plan(): every outcome, on small robots."""

import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.optimise.terms import Window, constraint
from trajopt.optimise.terms.frames import relative_frame
from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import Certainty, Status
from trajopt.problem.motion import Motion
from trajopt.problem.residual import END
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Rows
from trajopt.values.errors import PlanningFailed, ProblemError
from trajopt.verify import Evidence

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = {"pan": 1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return odd_arm(tmp_path_factory.mktemp("robot"))


@pytest.fixture(scope="module")
def pillar(arm: to.Robot) -> to.Scene:
    return to.Scene(arm).add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0.0, 0.3)))


def problem(scene: to.Scene, **changes: object) -> to.Problem:
    given: dict[str, object] = {"scene": scene, "start": START, "goal": to.joint_positions(GOAL)}
    return to.Problem(**{**given, **changes})  # pyright: ignore[reportArgumentType]


def test_around_a_pillar(pillar: to.Scene) -> None:
    result = to.plan(problem(pillar))
    assert result.status is Status.SOLVED, result.reason
    plan = result.require()
    assert plan.certificate.verified
    assert 0.0 < plan.certificate.clearance < 0.1
    trajectory = plan.trajectory
    assert trajectory(0.0) == pytest.approx(list(START.values()), abs=1e-9)
    assert trajectory(trajectory.duration) == pytest.approx(list(GOAL.values()), abs=1e-6)
    assert trajectory([0.0, trajectory.duration], 1) == pytest.approx(0.0, abs=1e-9)
    times = np.linspace(0.0, trajectory.duration, 5000)
    limits = result.problem.limits
    assert (np.abs(trajectory(times, 1)) <= limits.velocity * (1 + 1e-6)).all()
    assert (np.abs(trajectory(times, 2)) <= limits.acceleration * (1 + 1e-6)).all()
    assert set(result.cpu_seconds) == {"examine", "seed", "optimise", "retime", "verify"}
    for count in ("distance_calls", "forward_kinematics", "qp_solves", "qp_iterations"):
        assert result.counts[count] > 0


def test_the_same_answer_every_time(pillar: to.Scene) -> None:
    first, second = (to.plan(problem(pillar)).require().trajectory for _ in range(2))
    assert np.array_equal(first.positions, second.positions)
    assert np.array_equal(first.times, second.times)


def test_an_edit_of_the_scene_is_seen(arm: to.Robot, pillar: to.Scene) -> None:
    free = to.plan(problem(to.Scene(arm))).require()
    around = to.plan(problem(pillar)).require()
    moved = to.plan(problem(pillar.move("pillar", to.placement((5.0, 0, 0))))).require()
    assert around.path.length > free.path.length + 0.01
    assert moved.path.length == pytest.approx(free.path.length, abs=1e-6)


def test_pose_goal(pillar: to.Scene, arm: to.Robot) -> None:
    where = pillar.placement_of("tip", arm.positions(GOAL))
    goal = to.frame_placement("tip", where, rotation_tolerance=np.inf)
    plan = to.plan(problem(pillar, goal=goal)).require()
    reduced = plan.problem.reduced
    end = plan.trajectory(plan.trajectory.duration)
    reached = pillar.placement_of("tip", reduced.all_positions(end))
    assert np.abs(where.rotation.T @ (reached.translation - where.translation)).max() <= 1e-4


def test_continuous_joint_takes_the_short_way(arm: to.Robot) -> None:
    start = {**START, "pan": 3.0}
    where = to.Scene(arm).placement_of("tip", arm.positions({**GOAL, "pan": -3.0}))
    goal = to.frame_placement("tip", where, position_tolerance=1e-3, rotation_tolerance=np.inf)
    plan = to.plan(problem(to.Scene(arm), start=start, goal=goal)).require()
    assert np.ptp(plan.path.knots[:, 0]) < 0.6


def test_start_in_collision(pillar: to.Scene) -> None:
    result = to.plan(problem(pillar, start={**START, "pan": 0.0}))
    assert result.status is Status.START_IN_COLLISION
    assert "pillar" in result.reason
    with pytest.raises(PlanningFailed, match="pillar"):
        result.require()


def test_goal_in_collision(pillar: to.Scene) -> None:
    result = to.plan(problem(pillar, goal=to.joint_positions({**GOAL, "pan": 0.0})))
    assert result.status is Status.GOAL_IN_COLLISION
    assert "pillar" in result.reason


def test_out_of_limits(arm: to.Robot) -> None:
    beyond = {**GOAL, "elbow": 2.6}
    result = to.plan(problem(to.Scene(arm), goal=to.joint_positions(beyond)))
    assert result.status is Status.GOAL_OUT_OF_LIMITS
    assert "elbow" in result.reason
    result = to.plan(problem(to.Scene(arm), start=beyond))
    assert result.status is Status.START_OUT_OF_LIMITS


def test_out_of_reach(arm: to.Robot) -> None:
    goal = to.frame_placement("tip", to.placement((5.0, 0.0, 0.0)))
    assert to.plan(problem(to.Scene(arm), goal=goal)).status is Status.NO_INVERSE_KINEMATICS


def test_path_constraint_broken_at_the_start(arm: to.Robot) -> None:
    upright = to.axis_alignment("tip", direction=(1, 0, 0), tolerance=0.1)
    result = to.plan(problem(to.Scene(arm), constraints=[upright]))
    assert result.status is Status.START_BREAKS_CONSTRAINT


def test_an_enclosed_goal_is_proven_with_the_blocking_objects(arm: to.Robot) -> None:
    sheet = to.Box(1.6, 0.02, 3.0)
    scene = to.Scene(arm).add("sheet", sheet, to.placement((0.95, 0.0, 0.0)))
    scene = scene.add("other sheet", sheet, to.placement((-0.95, 0.0, 0.0)))
    result = to.plan(problem(scene))
    assert result.status is Status.PROVEN_INFEASIBLE
    assert "pan has to pass" in result.reason and "sheet" in result.reason
    assert result.trajectory is None or not result.verified


def test_meant_contact_is_allowed_for_its_time_only(arm: to.Robot) -> None:
    scene = to.Scene(arm).add(
        "part",
        to.Sphere(0.05),
        frame="tip",
        placement=to.placement((0.15, 0, 0)),
        touch_links=["tip", "finger"],
    )
    at_start = scene.placement_of("part", arm.positions(START)).translation
    scene = scene.add("shelf", to.Box(0.1, 0.1, 0.02), to.placement(at_start - [0, 0, 0.0599]))
    goal = to.joint_positions({**START, "reach": 0.2, "elbow": -0.6})
    assert to.plan(problem(scene, goal=goal)).status is Status.START_IN_COLLISION
    meant = scene.allow_contact("lift off", "part", "shelf", depth=2e-3, first=0.5)
    result = to.plan(problem(meant, goal=goal))
    assert result.verified, result.reason


def test_scaling_factors_slow_down(pillar: to.Scene) -> None:
    fast = to.plan(problem(pillar)).require().trajectory.duration
    slow = to.plan(problem(pillar, velocity_scaling=0.2)).require().trajectory.duration
    assert slow > 2.0 * fast


def test_progress_is_reported(pillar: to.Scene) -> None:
    seen: list[str] = []
    to.plan(problem(pillar), progress=lambda stage, step: seen.append(stage))
    assert {"examine", "optimise", "retime", "verify"} <= set(seen)


def test_a_problem_prints_its_contents(pillar: to.Scene) -> None:
    text = str(problem(pillar, constraints=[to.axis_alignment("tip", tolerance=0.5)], velocity_scaling=0.5))
    words = ("odd", "pillar", "tip", "0.5 of the velocity limits", "clearance 0 mm required, margin 10 mm")
    for word in (*words, "velocity", "acceleration"):
        assert word in text


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"group": "arms"}, "all"),
        ({"start": {"pam": 0.0}}, "pan"),
        ({"goal": ()}, "goal"),
        ({"knots": 2}, "knots"),
        ({"velocity_scaling": 0.0}, "velocity_scaling"),
        ({"goal": to.frame_placement("tipp", to.placement())}, "tip"),
        ({"constraints": [to.axis_alignment("tip", tolerance=0.1, reference="piller")]}, "pillar"),
        ({"start": np.zeros(3)}, "has 3 numbers"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_malformed_problems_are_refused(pillar: to.Scene, changes: dict[str, object], words: str) -> None:
    with pytest.raises(to.TrajoptError, match=words):
        problem(pillar, **changes)


def test_a_mimic_joint_cannot_have_a_goal_that_contradicts_its_leader(arm: to.Robot) -> None:
    goal = to.joint_positions({**GOAL, "follow": 1.0})
    result = to.plan(problem(to.Scene(arm), goal=goal))
    assert result.status is Status.CONFLICTING_CONSTRAINTS and result.certainty is Certainty.PROVEN
    assert "wrist" in result.reason


@dataclass(frozen=True)
class TipHeight:
    """A term of a user's own: height of the tip [m]."""

    reduced: ReducedModel
    name: str = "height of the tip"

    def linearise(self, motion: Motion) -> Rows:
        seen = relative_frame(self.reduced, motion, "tip", "world", np.zeros(3))
        return motion.rows_of_all(seen.point[:, 2:], seen.point_jacobian[:, 2:])


def test_a_constraint_in_user_code_is_held_and_sampled(arm: to.Robot) -> None:
    start, goal = {**START, "elbow": -0.5}, to.joint_positions({**GOAL, "elbow": -0.5})
    free = problem(to.Scene(arm), start=start, goal=goal)
    height = TipHeight(free.reduced)
    ends = to.Scene(arm).placement_of("tip", arm.positions(start)).translation[2]
    asked = problem(
        to.Scene(arm),
        start=start,
        goal=goal,
        constraints=[
            to.during(constraint(height, lower=-np.inf, upper=ends - 0.05), after="low", until="far")
        ],
        waypoints={
            "low": to.joint_positions({"pan": -0.3}, tolerance=0.05),
            "far": to.joint_positions({"pan": 0.3}, tolerance=0.05),
        },
    )
    certificate = to.plan(asked).require().certificate
    (check,) = (item for item in certificate.checks if "height of the tip" in item.name)
    assert "from low to far" in check.name
    assert check.holds and check.evidence is Evidence.SAMPLED
    with pytest.raises(ProblemError, match="during"):
        problem(
            to.Scene(arm),
            start=start,
            goal=goal,
            constraints=[constraint(height, lower=0.0, upper=1.0, window=Window(0.5, 0.5))],
        )
    whole = problem(
        to.Scene(arm),
        start=start,
        goal=goal,
        constraints=[constraint(height, lower=-np.inf, upper=ends + 0.001)],
    )
    certificate = to.plan(whole).require().certificate
    (check,) = (check for check in certificate.checks if "height of the tip" in check.name + check.subject)
    assert check.holds and check.evidence is Evidence.SAMPLED


def test_a_goal_configuration_is_free_where_a_constraint_of_the_user_speaks_of_the_end(arm: to.Robot) -> None:
    """The goal search does not know it: only the program can move the end to where it holds."""
    scene = to.Scene(arm)
    where = scene.placement_of("tip", arm.positions(GOAL))
    wide = to.frame_placement("tip", where, position_tolerance=0.1, rotation_tolerance=np.inf)
    heights = [where.translation[2] + share for share in (-0.06, 0.06)]
    for height in heights:
        at_end = constraint(
            TipHeight(problem(scene).reduced), lower=height - 0.01, upper=height + 0.01, window=END
        )
        plan = to.plan(problem(scene, goal=wide, constraints=[at_end])).require()
        end = plan.problem.reduced.all_positions(plan.path.knots[-1])
        assert abs(scene.placement_of("tip", end).translation[2] - height) < 0.012


def test_the_outcome_of_each_seed_is_reported(pillar: to.Scene) -> None:
    result = to.plan(problem(pillar))
    assert [item.number for item in result.attempts] == list(range(1, result.counts["attempts"] + 1))
    assert result.attempts[0].kind is SeedKind.STRAIGHT
    assert result.attempts[-1].status is Status.SOLVED and result.attempts[-1].solver is not None
    assert sum(item.iterations for item in result.attempts) == result.counts["qp_solves"]
    assert to.plan(problem(pillar, start={**START, "pan": 0.0})).attempts == ()


def test_the_planner_is_loaded_before_the_first_plan() -> None:
    code = """
import sys
import trajopt as to
assert "trajopt.planning.plan" not in sys.modules
to.Problem
assert "trajopt.planning.plan" in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True)

"""Placements that are held, requirements of parts of the motion, relative frames, and rest."""

import copy
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trajopt_robots

import trajopt as to
from benchmarks.proof_mutations import direct
from tests.files.proof.conftest import Checker, Document, Proof, moving_problem, planar_problem, planned
from tests.files.proof.dense import EXCEEDED, of_kind, refuted, torques
from tests.files.proof.test_bounds import arm
from trajopt.files.proof import MotionProof, check_proof, save_proof
from trajopt.problem.problem import named_problem
from trajopt.problem.requirements import FramePlacement

SWING = direct((-0.6, 0.3), (0.6, 0.3), 1.2)


def along(across: float) -> FramePlacement:
    return to.frame_placement(
        "tool", ALONG, position_tolerance=(np.inf, across, np.inf), rotation_tolerance=np.inf
    )


def kept(**asked: object) -> to.Problem:
    """A swing of the planar arm of 1.2 rad."""
    return to.Problem(scene=scene(), start=[-0.6, 0.3], name="swing", **{**GOAL, **asked})  # type: ignore[arg-type]


def scene() -> to.Scene:
    return to.Scene(to.load("planar2")).add("mark", to.Box(0.01, 0.01, 0.01), to.placement((0.0, 0.0, 0.6)))


GOAL: dict[str, object] = {"goal": to.joint_positions({"joint1": 0.6, "joint2": 0.3})}
ALONG = to.placement((0.8, 0.0, 0.14), rpy=(0.0, 0.0, 0.3))
"""The tool is within 0.4 m across and 0.6 rad of it, at the height."""


def proven(problem: to.Problem, path: Path) -> Proof:
    save_proof(problem, SWING, path)
    assert check_proof(path).words.endswith("\nPROVEN")
    found = Proof.read(path)
    assert found.statement["judged"] == []
    assert list(refuted(found.statement)) == []
    return found


def smallest(proof: Proof, change: Callable[[Document, float], object], most: float) -> float:
    """Return the smallest number for which the dense check still holds, by bisection."""
    low, high = 0.0, most
    for _ in range(30):
        middle = (low + high) / 2.0
        statement = copy.deepcopy(proof.statement)
        change(statement, middle)
        low, high = (middle, high) if any(refuted(statement)) else (low, middle)
    return high


def held(statement: Document) -> Document:
    (rule,) = of_kind(statement, "held placement")
    return rule


@pytest.mark.parametrize("seen", ["world", "tool"])
@pytest.mark.parametrize(("field", "axis"), [("position", 0), ("position", 1), ("rotation", 2)])
def test_a_held_placement_is_proven_up_to_its_tolerance(
    field: str, axis: int, seen: str, tmp_path: Path, checker: Checker
) -> None:
    """Also of a frame at rest as seen from one that the arm moves; a smaller tolerance is refused."""
    sizes = {"position_tolerance": (0.9, 0.9, 1e-6), "rotation_tolerance": (1e-6, 1e-6, 2.0)}
    required = to.frame_placement("tool", ALONG, **sizes)
    if seen == "tool":
        required = to.frame_placement(
            "mark", ALONG.inverse(), reference="tool", **{**sizes, "position_tolerance": 0.9}
        )
    proof = proven(kept(constraints=[required]), tmp_path / "x.proof")
    least = smallest(proof, lambda s, size: held(s)[field].__setitem__(axis, size), 3.0)
    for size, holds in ((1.001 * least + 1e-5, True), (0.999 * least - 1e-5, False)):
        held(proof.statement)[field][axis] = size
        assert (checker.fault(proof.write(tmp_path / "x.proof")) == "") is holds


CHANGES: dict[str, Callable[[Document], object]] = {
    "another place": lambda s: held(s)["goal"]["translation"].__setitem__(2, 0.1401),
    "a turned goal": lambda s: held(s)["goal"].update(rotation=[1.0, 1e-4, 0.0, 0.0]),
    "another point": lambda s: held(s)["place"]["translation"].__setitem__(2, 0.001),
    "another joint": lambda s: held(s)["goal"].update(joint=1),
    "half a turn": lambda s: held(s)["goal"].update(rotation=[0.0, 0.0, 0.0, 1.0]),
}


@pytest.mark.parametrize("change", CHANGES)
def test_other_placements_are_refused(change: str, tmp_path: Path, checker: Checker) -> None:
    required = to.frame_placement(
        "tool", ALONG, position_tolerance=(0.9, 0.9, 1e-5), rotation_tolerance=(1e-5, 1e-5, 1.5)
    )
    proof = proven(kept(constraints=[required]), tmp_path / "x.proof")
    CHANGES[change](proof.statement)
    assert "tool" in checker.fault(proof.write(tmp_path / "x.proof"))


def test_a_placement_too_near_its_tolerance_is_listed_as_judged(tmp_path: Path) -> None:
    """The judge counts an excess that the writer does not use up."""
    path = tmp_path / "x.proof"
    proof = proven(kept(constraints=[along(0.9)]), path)
    least = smallest(proof, lambda s, size: held(s)["position"].__setitem__(1, size), 1.0)
    save_proof(kept(constraints=[along(least + 5e-8)]), SWING, path)
    assert Proof.read(path).statement["judged"] == [f"at all times: {along(least + 5e-8)}"]
    assert not of_kind(Proof.read(path).statement, "held placement")


def test_requirements_between_waypoints_are_proven_in_their_part(tmp_path: Path, checker: Checker) -> None:
    half = {"half": to.joint_positions({"joint1": 0.0})}
    slow = to.during(to.joint_positions({"joint1": 0.0}, tolerance=0.61), after="half")
    problem = kept(waypoints=half, constraints=[slow])
    proof = proven(problem, tmp_path / "x.proof")
    (part,) = of_kind(proof.statement, "part")
    assert (part["since"], part["until"]) == (pytest.approx(0.6, abs=0.05), 1.2)
    part["requirement"]["ranges"] = [[1, -0.001, 0.61]]
    found = Proof.read(proof.write(tmp_path / "x.proof"))
    assert checker.fault(tmp_path / "x.proof") == "" or part["since"] < 0.6
    part["since"] = 0.0
    assert "from 0 to 1.2 s joint1" in checker.fault(proof.write(tmp_path / "x.proof"))
    part["requirement"]["always"] = False
    with pytest.raises(checker.malformed, match="one of all times"):
        checker.fault(proof.write(tmp_path / "x.proof"))
    part["requirement"] = {**found.statement["requirements"][0], "kind": []}
    with pytest.raises(checker.malformed):
        checker.fault(proof.write(tmp_path / "x.proof"))


def test_the_rest_of_a_dwell_and_a_deadline_are_proven(tmp_path: Path, checker: Checker) -> None:
    problem = replace(moving_problem(), dwell=0.5, finish_by=3.0)
    proof = planned(problem, tmp_path / "x.proof")
    assert proof.statement["judged"] == []
    (rest,) = of_kind(proof.statement, "rest")
    times = proof.statement["motion"]["times"]
    assert rest["since"] == times[-2] == pytest.approx(times[-1] - 0.5)
    assert checker.fault(tmp_path / "x.proof") == ""
    assert MotionProof(proof.data).check(fast=True).proven
    for changes in ({"since": rest["since"] - 0.1}, {"by": rest["since"] - 0.01}, {"since": times[-1] + 1.0}):
        changed = Proof(copy.deepcopy(proof.statement), proof.witness)
        of_kind(changed.statement, "rest")[0].update(changes)
        assert "the motion rests from" in checker.fault(changed.write(tmp_path / "y.proof"))
    proof.statement["motion"]["values"][0][-1][0] += 0.001
    assert checker.fault(proof.write(tmp_path / "y.proof"))


def test_an_object_that_comes_during_the_dwell_needs_leaves(tmp_path: Path, checker: Checker) -> None:
    """Moved to where the arm rests, it is refused, though it appears after the end of the motion."""
    late = planar_problem().scene.add("late", to.Sphere(0.05), to.placement((1.4, 0.5, 0.1)), appears=2.0)
    proof = planned(replace(planar_problem(), scene=late, dwell=1.5), tmp_path / "x.proof")
    assert checker.fault(tmp_path / "x.proof") == ""
    part = next(part for part in proof.statement["parts"] if part["owner"] == "late")
    part["place"]["translation"] = [0.6, 0.75, 0.14]
    assert "late" in checker.fault(proof.write(tmp_path / "x.proof"))


def steady(statement: Document) -> Document:
    (rule,) = of_kind(statement, "steady speed")
    return rule


UNSTEADY: dict[str, Callable[[Document], object]] = {
    "a ramp counts": lambda rule: rule.update(since=0.0),
    "a higher speed": lambda rule: rule.update(least=1.01 * rule["least"]),
    "less than half of the way": lambda rule: rule.update(until=0.55),
    "a span of no time": lambda rule: rule.update(since=0.6, until=0.6),
    "a point at rest": lambda rule: rule["place"].update(joint=0),
}


@pytest.mark.parametrize("change", UNSTEADY)
def test_a_steady_speed_is_proven_over_half_of_the_way(change: str, tmp_path: Path, checker: Checker) -> None:
    limited = to.tool_speed("tool", linear=2.2, steady=0.5)
    proof = proven(kept(tool_speed=limited), tmp_path / "x.proof")
    rule = steady(proof.statement)
    assert rule["least"] == pytest.approx(1.1)
    assert 0.0 < rule["since"] < 0.6 < rule["until"] < 1.2
    UNSTEADY[change](rule)
    assert "over half of the way" in checker.fault(proof.write(tmp_path / "x.proof"))


def test_torques_of_gravity_are_proven_at_all_times(tmp_path: Path, checker: Checker) -> None:
    """With limits near the largest torque of a robot at rest, which is not that of the motion."""
    proof = planned(named_problem("heavy_payload_panda"), tmp_path / "x.proof")
    assert check_proof(tmp_path / "x.proof").words.endswith("\nPROVEN")
    assert proof.statement["judged"] == []
    (rule,), (moving,) = (of_kind(proof.statement, kind) for kind in ("gravity torque", "torque"))
    times = np.linspace(0.0, proof.statement["motion"]["times"][-1], 500)
    largest, of_motion = (
        np.abs(torques(proof.statement, each, times)).max(axis=0) for each in (rule, moving)
    )
    assert np.abs(largest - of_motion).max() > 1.0
    for coordinate, most in enumerate(largest.tolist()):
        for limit, holds in ((1.01 * most + 0.02, True), (0.99 * most - 0.02, False)):
            if limit > 0.0:
                rule["limits"] = [[coordinate, limit]]
                assert (checker.fault(proof.write(tmp_path / "x.proof")) == "") is holds


def test_an_angular_speed_is_proven_at_all_times(tmp_path: Path, checker: Checker) -> None:
    """The swing turns the tool at 1.875 rad/s in its middle."""
    limited = to.tool_speed("tool", angular=1.9)
    proof = proven(kept(tool_speed=limited), tmp_path / "x.proof")
    (rule,) = of_kind(proof.statement, "angular speed")
    assert of_kind(proof.statement, "tool speed") == []
    rule["limit"] = 1.874
    assert any(refuted(proof.statement))
    assert "tool on joint2 turns" in checker.fault(proof.write(tmp_path / "x.proof"))


@pytest.mark.parametrize("degree", [3, 5])
@pytest.mark.parametrize("joint", [2, 3, 5])
def test_an_angular_speed_is_bounded_tightly(degree: int, joint: int, checker: Checker) -> None:
    """Joints of any axes, one that slides among them; samples find the largest speed from below."""
    stated = arm(np.random.default_rng(joint), degree)
    grid = np.unique(np.concatenate((stated["motion"]["times"], np.linspace(0.0, 2.0, 2001))))
    place = {"joint": joint, "rotation": [1, 0, 0, 0], "translation": [0.1, 0, 0]}
    rule = {"kind": "angular speed", "frame": "hand", "place": place, "limit": 0.0}
    exceeded = EXCEEDED["angular speed"](stated, rule, np.linspace(1e-4, 2.0 - 1e-4, 4001))
    largest = float(exceeded.max())
    statement = checker.modules["statement"].read_statement(stated)
    found = checker.modules["kinematics"].GridKinematics(statement, grid)
    read = checker.modules["rule_orientation"].read_speed
    for share, holds in ((1.001, True), (0.9999, False)):
        shown = read({**rule, "limit": share * largest}, statement).holds(found)
        assert bool(shown.all()) == holds


def test_a_rest_is_proven_after_an_end_without_a_limit_of_jerk(tmp_path: Path, checker: Checker) -> None:
    """The arm brakes until its end, where its acceleration jumps to zero."""
    folder = Path(trajopt_robots.__file__).parent / "planar2"
    robot = to.load(folder / "planar2.urdf", srdf=folder / "planar2.srdf")
    problem = replace(kept(dwell=0.5), scene=to.Scene(robot))
    plan = to.plan(problem).require()
    assert plan.trajectory.accelerations is not None
    assert np.abs(plan.trajectory.accelerations[-1]).max() > 1.0
    plan.save_proof(tmp_path / "x.proof")
    proof = Proof.read(tmp_path / "x.proof")
    assert proof.statement["judged"] == []
    assert of_kind(proof.statement, "rest")[0]["since"] == plan.trajectory.duration
    assert checker.fault(tmp_path / "x.proof") == ""
    assert list(refuted(proof.statement)) == []

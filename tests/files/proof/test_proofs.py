"""Proofs that are written for verified motions are accepted by the checker."""

import copy
import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.cli.process import trajopt
from tests.files.proof.conftest import Checker, Proof, planar_problem, planned
from trajopt.files.export import export
from trajopt.files.proof import MotionProof, save_proof
from trajopt.files.proof.proof import CHECKER
from trajopt.problem.problem import named_problem
from trajopt.values.errors import ProblemError

BLOCKED = """
import runpy, sys
sys.modules["trajopt"] = sys.modules["pinocchio"] = sys.modules["coal"] = sys.modules["scipy"] = None
folder, path = sys.argv[1:]
sys.argv = ["checker", path]
runpy.run_path(folder, run_name="__main__")
"""


def proof_of_ur5(path: Path) -> Proof:
    try:
        robot = to.load("ur5")
    except to.MissingExtra as missing:
        pytest.skip(str(missing))
    scene = to.Scene(robot).add("pillar", to.Cylinder(0.05, 0.8), to.placement((-0.5, 0.0, 0.4)))
    scene = scene.add("floor", to.Plane(), to.placement((0.0, 0.0, -0.05))).allow("floor", "base_link")
    goal = to.frame_placement("tool0", to.placement((0.4, 0.4, 0.3), rpy=(3.1, 0.0, 0.0)))
    start = [0.0, -1.2, 1.2, -1.5, -1.5, 0.0]
    return planned(to.Problem(scene=scene, group="manipulator", start=start, goal=goal, name="ur5"), path)


def test_a_plan_is_proven_by_a_copy_of_the_checker_without_trajopt(tmp_path: Path, planar: Proof) -> None:
    folder = shutil.copytree(CHECKER, tmp_path / "elsewhere", ignore=shutil.ignore_patterns("__pycache__"))
    path = planar.write(tmp_path / "x.proof")
    run = subprocess.run(
        [sys.executable, "-I", "-c", BLOCKED, str(folder), str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    first, *_, last = run.stdout.splitlines()
    assert first.startswith("planar fold: for all t in [0, ")
    assert last == "PROVEN"


def test_an_arm_with_a_frame_goal_and_a_half_space_is_proven(tmp_path: Path, checker: Checker) -> None:
    proof = proof_of_ur5(tmp_path / "ur5.proof")
    assert checker.fault(tmp_path / "ur5.proof") == ""
    kinds = {part["shape"]["kind"] for part in proof.statement["parts"]}
    assert kinds == {"hull", "frustum", "half-space"}
    goal = proof.statement["requirements"][0]
    assert goal["kind"] == "frame placement"
    goal["goal"]["translation"][0] += 0.001
    assert "tool0" in checker.fault(proof.write(tmp_path / "moved.proof"))
    goal["goal"]["translation"][0] -= 0.001
    w, x, y, z = goal["goal"]["rotation"]
    goal["goal"]["rotation"] = [w + 0.003 * x, x - 0.003 * w, y, z]
    assert "tool0" in checker.fault(proof.write(tmp_path / "turned.proof"))
    # By half a turn a rotation vector is not known, and not needed where all axes are free.
    goal["goal"]["rotation"], goal["rotation"] = [-x, w, -z, y], [None] * 3
    assert checker.fault(proof.write(tmp_path / "free.proof")) == ""


def test_every_kind_of_requirement_is_proven(tmp_path: Path, checker: Checker, required: Proof) -> None:
    path = required.write(tmp_path / "x.proof")
    assert checker.fault(path) == ""
    stated = required.statement["requirements"]
    assert {each["kind"] for each in stated} == {
        "joint positions", "axis alignment", "position in region", "tool speed", "torque",
    }  # fmt: skip
    assert {each["always"] for each in stated if each["kind"] == "position in region"} == {True, False}
    assert required.statement["judged"] == []


def test_waypoints_are_proven_at_a_moment_of_the_grid(tmp_path: Path, checker: Checker) -> None:
    way = to.position_in_region("tool", to.Sphere(0.02), to.placement((0.75, 0.3, 0.14)))
    problem = replace(planar_problem(), waypoints={"over": way, "high": to.joint_positions({"joint1": 0.6})})
    proof = planned(problem, tmp_path / "x.proof")
    assert proof.statement["judged"] == []
    over, high = (each for each in proof.statement["requirements"] if each["kind"] == "waypoint")
    assert (over["name"], high["name"]) == ("over", "high")
    assert 0.0 < over["time"] <= high["time"]

    def faults() -> tuple[str, str]:
        return checker.fault(proof.write(tmp_path / "x.proof")), MotionProof(proof.data).fast_fault

    assert faults() == ("", "")
    passed = over["time"]
    for time in (np.nextafter(passed, 0.0), 0.0, proof.statement["motion"]["times"][-1], 99.0):
        over["time"] = float(time)
        assert all("waypoint over" in fault for fault in faults())
    over["time"] = passed
    over["requirement"]["always"] = True
    with pytest.raises(checker.malformed, match="one of the end"):
        faults()
    assert "one of the end" in MotionProof(proof.data).fast_fault
    over["requirement"] = copy.deepcopy(high)
    with pytest.raises(checker.malformed, match="kind of a requirement"):
        faults()


def test_a_part_keeps_apart_outside_of_its_accepted_contact(tmp_path: Path, checker: Checker) -> None:
    """It lies on a table at first; where contact is not accepted, both kernels refuse its leaf."""
    table = to.placement((0.53, -0.788, 0.14))
    scene = to.Scene(to.load("planar2")).add("table", to.Box(0.3, 0.1, 0.1), table).allow("table", "link2")
    low = {"joint1": -1.1, "joint2": 0.3}
    scene = scene.add("part", to.Box(0.04, 0.04, 0.04), to.placement((0.0, 0.0, 0.0)), frame="tool")
    scene = scene.allow("part", "link2").allow_contact("lift", "part", "table", depth=0.05, first=0.4)
    goal = to.joint_positions({"joint1": 0.9, "joint2": 0.4})
    proof = planned(to.Problem(scene=scene, start=low, goal=goal, name="lift"), tmp_path / "x.proof")
    assert proof.statement["contacts"] == [["part", "table", 0.4, None]]
    assert not any({"part", "table"} == set(row[:2]) for row in proof.statement["excused"])
    assert proof.statement["judged"] == ["contact of part and table: at most 50 mm deep"]

    def faults() -> tuple[str, str]:
        return checker.fault(proof.write(tmp_path / "x.proof")), MotionProof(proof.data).fast_fault

    assert faults() == ("", "")
    proof.statement["contacts"][0][:2] = ["table", "part"]
    assert faults() == ("", "")
    for contact in (["part", "table", None, None], ["part", "post", 0.4, None]):
        proof.statement["contacts"] = [contact]
        assert all("part and table" in fault or "table and part" in fault for fault in faults())


def test_a_motion_that_follows_its_goal_need_not_end_at_rest(tmp_path: Path, checker: Checker) -> None:
    try:
        problem = named_problem("conveyor_ur5")
    except to.MissingExtra as missing:
        pytest.skip(str(missing))
    proof = planned(problem, tmp_path / "x.proof")
    assert checker.fault(tmp_path / "x.proof") == ""
    assert proof.statement["ends"]["rests"] is False
    assert [each[0] for each in proof.statement["changes"]] == ["part"]


def test_attached_objects_and_required_clearances_are_in_the_statement(
    tmp_path: Path, checker: Checker
) -> None:
    problem = planar_problem()
    scene = problem.scene.add("part", to.Box(0.05, 0.05, 0.05), to.placement((0.0, 0.0, 0.0)), frame="tool")
    scene = scene.with_clearance(0.002).allow("part", "link2").allow("part", "tool")
    proof = planned(
        to.Problem(scene=scene, start=problem.start, goal=problem.goal, name="carried"), tmp_path / "x.proof"
    )
    assert checker.fault(tmp_path / "x.proof") == ""
    owners = [part["owner"] for part in proof.statement["parts"]]
    pairs = {(owners[one], owners[other], level) for one, other, level in proof.statement["pairs"]}
    assert ("part", "post", 0.002) in pairs or ("post", "part", 0.002) in pairs


def test_motions_that_are_refused_or_linear_have_no_proof(tmp_path: Path, planar_plan: to.Plan) -> None:
    motion = planar_plan.trajectory
    fast = to.Trajectory(motion.joint_names, motion.times / 2, motion.positions, motion.velocities * 2)
    with pytest.raises(ProblemError, match="judge refuses"):
        save_proof(planar_problem(), fast, tmp_path / "x.proof")
    linear = to.Trajectory(motion.joint_names, motion.times, motion.positions)
    with pytest.raises(ProblemError, match="velocities"):
        save_proof(planar_problem(), linear, tmp_path / "x.proof")
    assert not (tmp_path / "x.proof").exists()


def test_a_name_that_the_checker_cannot_print_is_refused(tmp_path: Path) -> None:
    problem = planar_problem()
    scene = problem.scene.add("line\nbreak", to.Sphere(0.02), to.placement((0.0, 0.0, 0.9)))
    plan = to.plan(replace(problem, scene=scene, name="two\nlines")).require()
    with pytest.raises(ProblemError, match=r"printable names .*, not 'line\\nbreak'"):
        plan.save_proof(tmp_path / "x.proof")
    plan = to.plan(replace(problem, name="two\nlines")).require()
    plan.save_proof(tmp_path / "x.proof")
    assert MotionProof.read(tmp_path / "x.proof").check().words.startswith("two lines")


def test_the_commands_prove_and_check(tmp_path: Path, planar_plan: to.Plan) -> None:
    planar_plan.save(tmp_path / "x.trajopt")
    proven = trajopt("prove", str(tmp_path / "x.trajopt"), "--out", str(tmp_path / "x.proof"))
    assert proven.returncode == 0, proven.stderr
    assert "PROVEN" in proven.stdout and "leaves" in proven.stdout
    checked = trajopt("check", str(tmp_path / "x.proof"), "--json")
    assert checked.returncode == 0
    assert json.loads(checked.stdout)["proven"] is True
    data = (tmp_path / "x.proof").read_bytes()
    (tmp_path / "x.proof").write_bytes(data[:-1])
    assert trajopt("check", str(tmp_path / "x.proof")).returncode == 2


def test_a_bundle_has_the_problem_of_a_motion_in_another_file(tmp_path: Path, planar_plan: to.Plan) -> None:
    bundle, motion = tmp_path / "x.trajopt", tmp_path / "x.yaml"
    planar_plan.save(bundle)
    export(planar_plan, motion, to="ros2")
    proven = trajopt("prove", str(motion), "--request", str(bundle), "--out", str(tmp_path / "x.proof"))
    assert proven.returncode == 0 and "PROVEN" in proven.stdout, proven.stderr
    assert trajopt("check", str(motion), "--request", str(bundle)).returncode == 0
    for words in ((motion, "--request", bundle, "--robot", "planar2"), (bundle, "--scene", "a.yaml")):
        refused = trajopt("check", *map(str, words))
        assert refused.returncode == 2
        assert "leave out --robot, --scene, --request and --motions" in refused.stderr

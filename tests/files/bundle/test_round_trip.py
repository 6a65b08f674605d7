"""What is saved is read again to the last digit, on a machine that has never seen the robot."""

import json
import pickle
import subprocess
import sys
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

import trajopt as to
from trajopt.files.bundle import Holds, read_bundle, save
from trajopt.files.bundle.codec import BundleReader, BundleWriter, kinematics_document, model_from
from trajopt.files.proof import MotionProof, prove
from trajopt.files.proof.pairs import MEETING, TOUCHING
from trajopt.optimise.terms.user_functions import FunctionResidual
from trajopt.planning import Result
from trajopt.problem.problem import named_problem
from trajopt.problem.residual import Constraint
from trajopt.values.documents.document import Node
from trajopt.values.errors import FileFormatError, ModelError, ProblemError
from trajopt.values.shapes.shapes import Convex, convex

from .conftest import members_of, write_members

EVERY_KIND = (
    *("cup_past_pillar", "wiping_panda", "keep_in_view_panda", "two_arms_tray", "past_column_pr2"),
    *("wide_berth", "weld_seam_panda", "past_column_tiago", "pick_and_place_ur5", "elbow_kept"),
)


def again(value: object) -> object:
    """Write a value and read it again."""
    writer = BundleWriter()
    document = writer.document(value, "value")
    return BundleReader(lambda name: writer.arrays[name], Path).value(Node(document, "here"))


def test_a_plan_is_read_as_it_was(solved: Result, kept: Path) -> None:
    bundle = read_bundle(kept)
    assert bundle.holds is Holds.PLAN
    assert bundle.status == "SOLVED"
    assert solved.trajectory is not None and bundle.trajectory is not None
    for name in ("times", "positions", "velocities", "accelerations"):
        np.testing.assert_array_equal(getattr(bundle.trajectory, name), getattr(solved.trajectory, name))
    assert str(bundle.problem) == str(solved.problem)
    assert bundle.judged().verified
    assert "past a ball" in str(bundle) and "a plan" in str(bundle)


def test_a_proof_is_kept_and_checked(solved: Result, tmp_path: Path) -> None:
    solved.require().save(tmp_path / "plan.trajopt", proof=True)
    assert "  answer       SOLVED\n" in str(read_bundle(tmp_path / "plan.trajopt"))
    solved.save(tmp_path / "result.trajopt", proof=True)
    proof = read_bundle(tmp_path / "plan.trajopt").proof
    assert proof is not None and proof.check().proven
    other = read_bundle(tmp_path / "result.trajopt").proof
    assert other is not None and other.data == proof.data
    solved.require().save_proof(tmp_path / "x.proof")
    assert (tmp_path / "x.proof").read_bytes() == proof.data


def excusing(proof: MotionProof, reason: str) -> bytes:
    """Return a proof with another reason for its excuses."""
    excused = [[*owners, reason] for *owners, _ in cast("Any", proof.statement["excused"])]
    stated = json.dumps({**proof.statement, "excused": excused}).encode()
    return b"proof/1 %d\n" % len(stated) + stated + sha256(stated).digest() + proof.witness


def test_a_proof_of_another_motion_or_scene_is_refused(solved: Result, kept: Path, tmp_path: Path) -> None:
    assert read_bundle(kept).proof is None
    problem, plan = solved.problem, solved.require()
    motion = plan.trajectory
    slower = to.Trajectory(
        motion.joint_names,
        2.0 * motion.times,
        motion.positions,
        motion.velocities / 2.0,
        motion.accelerations / 4.0,
    )
    moved = replace(problem, scene=problem.scene.move("ball", to.placement((0.65, 0.7, 0.1))))
    touching = replace(problem, scene=problem.scene.allow("ball"))
    ends = dict(zip(motion.joint_names, motion.positions[-1].tolist(), strict=True))
    wider = replace(problem, goal=to.joint_positions(ends, tolerance=0.1))
    members = members_of(kept)
    for field, proof in {
        "pairs": prove(touching, motion).data,
        "its pairs differs": excusing(prove(touching, motion), MEETING),
        "its pairs": excusing(prove(touching, motion), TOUCHING),
        "requirements": prove(wider, motion).data,
        "motion": prove(problem, slower).data,
        "parts": prove(moved, motion).data,
        "title": prove(replace(problem, name="another"), motion).data,
        "statement": b"proof/1 3\n{}}" + bytes(36),
        "proof/1": b"proven",
    }.items():
        path = write_members(tmp_path / "other.trajopt", {**members, "motion.proof": proof})
        with pytest.raises(FileFormatError, match=field):
            read_bundle(path)
    with pytest.raises(ProblemError, match="no motion"):
        save(problem, tmp_path / "x.trajopt", proof=True)


@pytest.mark.parametrize("name", EVERY_KIND)
def test_problems_are_written_as_they_were_read(name: str) -> None:
    """The document of what was read is the document that it was read from: nothing is lost on the way."""
    problem = named_problem(name)
    writer, twice = BundleWriter(), BundleWriter()
    document = writer.document(problem, "problem")

    def files(name: str) -> Path:
        return writer.files.get(name, Path(name))

    read = BundleReader(lambda member: writer.arrays[member], files).value(Node(document, "here"))
    assert twice.document(read, "problem") == document
    assert list(twice.arrays) == list(writer.arrays)
    for member, array in writer.arrays.items():
        np.testing.assert_array_equal(twice.arrays[member], array)
    assert str(read) == str(problem)


@pytest.mark.parametrize("name", ["panda", "ur5", "two_pandas", "xarm7", "planar2"])
def test_models_are_the_same_bit_by_bit(name: str) -> None:
    model = to.load(name).model
    made = model_from(Node(kinematics_document(model), "here"))
    assert made.saveToString() == model.saveToString()


@pytest.mark.parametrize("kind", ["continuous", "revolute", "prismatic"])
def test_a_joint_about_any_axis_is_kept_to_the_last_digit(kind: str, tmp_path: Path) -> None:
    urdf = tmp_path / "turn.urdf"
    urdf.write_text(
        f'<robot name="turn"><link name="a"/><link name="b"/><joint name="j" type="{kind}">'
        '<parent link="a"/><child link="b"/><axis xyz="0.2 1.0 -0.3"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    model = to.Robot.from_urdf(urdf).model
    assert model_from(Node(kinematics_document(model), "here")).saveToString() == model.saveToString()


def test_hulls_are_taken_as_they_are() -> None:
    """Not computed anew: another library of hulls could order them otherwise."""
    hull = convex(np.random.default_rng(1).normal(size=(40, 3)))
    made = again(hull)
    assert isinstance(made, Convex)
    np.testing.assert_array_equal(made.vertices, hull.vertices)
    np.testing.assert_array_equal(made.faces, hull.faces)


def test_a_problem_and_a_failure_are_kept_too(solved: Result, tmp_path: Path) -> None:
    solved.problem.save(tmp_path / "problem.trajopt")
    bundle = read_bundle(tmp_path / "problem.trajopt")
    assert bundle.holds is Holds.PROBLEM and bundle.arguments is None and not bundle.answer
    with pytest.raises(ModelError, match="a problem, and no motion"):
        bundle.judged()
    failed = to.plan(named_problem("goal_beyond_limits"))
    failed.save(tmp_path / "failed.trajopt")
    bundle = read_bundle(tmp_path / "failed.trajopt")
    assert bundle.holds is Holds.FAILURE
    assert bundle.status == failed.status.name
    assert bundle.explanation["status"] == failed.status.name


def test_code_of_the_callers_is_refused_by_name(solved: Result, tmp_path: Path) -> None:
    def above(positions: np.ndarray) -> np.ndarray:
        return positions[:1]

    residual = FunctionResidual("above", above, None, 1e-6)
    problem = to.Problem(
        scene=solved.problem.scene,
        start=[0.0, 0.4],
        goal={"joint1": 1.4, "joint2": 0.4},
        constraints=[Constraint(residual, np.array([-1.0]), np.array([3.0]))],
    )
    with pytest.raises(ModelError, match=r"problem.constraints\[0\].residual cannot be written"):
        save(problem, tmp_path / "code.trajopt")
    assert not (tmp_path / "code.trajopt").exists()


def test_the_same_content_makes_the_same_members(solved: Result, tmp_path: Path) -> None:
    for name in ("one", "other"):
        solved.save(tmp_path / f"{name}.trajopt")
    one, other = (read_bundle(tmp_path / f"{name}.trajopt") for name in ("one", "other"))
    assert pickle.dumps(one.problem) == pickle.dumps(other.problem)


def test_it_is_judged_where_the_robot_was_never_seen(tmp_path: Path) -> None:
    """In another process that cannot load any robot: the file says all."""
    result = to.plan(named_problem("cup_past_pillar"))
    result.save(tmp_path / "cup.trajopt")
    code = (
        "import sys, trajopt.robot.load\n"
        "trajopt.robot.load.load = None\n"
        "from trajopt.files.bundle import read_bundle\n"
        "bundle = read_bundle(sys.argv[1])\n"
        "assert 'trajopt_robots' not in str(sys.modules)\n"
        "print(bundle.judged().verified)"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "cup.trajopt")],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert ended.stdout.strip() == "True"


def test_bundles_of_newer_versions_are_refused(kept: Path, tmp_path: Path) -> None:
    from .conftest import members_of, write_members

    members = members_of(kept)
    members["bundle.json"] = members["bundle.json"].replace(b'"version": 1', b'"version": 2')
    with pytest.raises(FileFormatError, match="version: is 2; this trajopt reads 1"):
        read_bundle(write_members(tmp_path / "newer.trajopt", members))

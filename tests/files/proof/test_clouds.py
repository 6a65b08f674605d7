"""Clouds are within convex parts, each as coarse as the motion allows."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.files.proof.conftest import Checker, Document, Proof, planar_problem, planned
from tests.files.proof.dense import of_kind, refuted
from trajopt.files.proof import MotionProof, check_proof, proof
from trajopt.values.errors import ProblemError

RADIUS = 0.01
POST = to.placement((0.65, 0.0, 0.1))


def measured_post() -> to.Points:
    """The post of `planar_problem`, as balls on its side."""
    angle, height = np.meshgrid(np.linspace(0.0, 6.2, 24), np.linspace(-0.2, 0.2, 41))
    points = np.stack((0.03 * np.cos(angle), 0.03 * np.sin(angle), height), axis=-1)
    return to.Points(points.reshape(-1, 3), RADIUS)


def cells_of_post() -> to.Voxels:
    return to.Voxels(np.unique(np.floor(measured_post().points / RADIUS), axis=0), RADIUS)


def past(post: to.Points | to.Voxels) -> to.Problem:
    problem = planar_problem()
    return replace(problem, scene=problem.scene.remove("post").add("post", post, POST))


@pytest.fixture(scope="module")
def balls(tmp_path_factory: pytest.TempPathFactory) -> Proof:
    return planned(past(measured_post()), tmp_path_factory.mktemp("balls") / "balls.proof")


@pytest.fixture(scope="module")
def cubes(tmp_path_factory: pytest.TempPathFactory) -> Proof:
    return planned(past(cells_of_post()), tmp_path_factory.mktemp("cubes") / "cubes.proof")


def cloud(statement: Document) -> Document:
    (rule,) = of_kind(statement, "cloud")
    return rule


@pytest.mark.parametrize(("name", "solids"), [("balls", 984), ("cubes", len(cells_of_post()))])
def test_a_motion_past_a_cloud_is_proven(
    name: str, solids: int, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    proven: Proof = request.getfixturevalue(name)
    assert proven.statement["judged"] == []
    assert 1 <= len(cloud(proven.statement)["inside"]) <= 100
    assert sum(len(centres) for _, centres in cloud(proven.statement)["inside"]) == solids
    answer = check_proof(proven.write(tmp_path / "x.proof"))
    assert answer.proven
    assert (
        f"{solids} {name} of post, each {2000.0 * cloud(proven.statement)['size']:g} mm wide" in answer.words
    )
    assert list(refuted(proven.statement)) == []


def test_the_fast_kernel_leaves_clouds_to_the_checker(balls: Proof, tmp_path: Path) -> None:
    found = MotionProof.read(balls.write(tmp_path / "x.proof"))
    assert "the fast kernel cannot read it: kind of a requirement" in found.fast_fault
    assert found.check(fast=True).words.endswith("\nPROVEN")


def group_of(statement: Document) -> list[Any]:
    """Return a part's number and the centres in it; at least two."""
    group = max(cloud(statement)["inside"], key=lambda each: len(each[1]))
    assert len(group[1]) > 1
    return group


def vertices(statement: Document) -> list[list[float]]:
    return statement["parts"][group_of(statement)[0]]["shape"]["vertices"]


def outermost(statement: Document) -> list[float]:
    return max(group_of(statement)[1], key=lambda centre: centre[2])


CHANGES: dict[str, Callable[[Document], object]] = {
    "a centre moved by a millimetre": lambda s: outermost(s).__setitem__(2, outermost(s)[2] + 1e-3),
    "a centre moved by one double": lambda s: outermost(s).__setitem__(2, np.nextafter(outermost(s)[2], 9.0)),
    "a further centre": lambda s: group_of(s)[1].append([0.3, 0.0, 0.0]),
    "a larger size": lambda s: cloud(s).update(size=np.nextafter(cloud(s)["size"], 1.0)),
    "a part of another shape": lambda s: s["parts"][group_of(s)[0]].update(
        shape={"kind": "frustum", "bottom": 9.0, "top": 9.0, "length": 9.0}
    ),
    "a corner removed": lambda s: vertices(s).pop(3),
    "a corner moved inward": lambda s: vertices(s)[0].__setitem__(0, vertices(s)[0][0] + 1e-9),
}


@pytest.mark.parametrize("name", ["balls", "cubes"])
@pytest.mark.parametrize("change", CHANGES)
def test_points_outside_of_their_part_are_refused(
    change: str, name: str, request: pytest.FixtureRequest, tmp_path: Path, checker: Checker
) -> None:
    proven = Proof.read(request.getfixturevalue(name).write(tmp_path / "x.proof"))
    CHANGES[change](proven.statement)
    assert checker.fault(proven.write(tmp_path / "x.proof"))


def test_balls_are_not_cubes(balls: Proof, tmp_path: Path, checker: Checker) -> None:
    proven = Proof.read(balls.write(tmp_path / "x.proof"))
    cloud(proven.statement)["cubes"] = True
    assert "cubes of post" in checker.fault(proven.write(tmp_path / "x.proof"))


def test_a_cloud_is_in_parts_of_its_own(balls: Proof, tmp_path: Path, checker: Checker) -> None:
    proven = Proof.read(balls.write(tmp_path / "x.proof"))
    group_of(proven.statement)[0] = 0
    with pytest.raises(checker.malformed, match="parts of its own"):
        checker.fault(proven.write(tmp_path / "x.proof"))


def test_a_part_of_a_cloud_must_keep_apart(balls: Proof, tmp_path: Path, checker: Checker) -> None:
    """Without its pairs it is left out; moved to the arm with its points, its leaves do not hold."""
    proven = Proof.read(balls.write(tmp_path / "x.proof"))
    number, centres = group_of(proven.statement)
    proven.statement["parts"].append({**proven.statement["parts"][number], "owner": "post"})
    cloud(proven.statement)["inside"].append([len(proven.statement["parts"]) - 1, centres])
    assert "neither a pair nor excused" in checker.fault(proven.write(tmp_path / "x.proof"))
    proven = Proof.read(balls.write(tmp_path / "x.proof"))
    for part in proven.statement["parts"]:
        if part["owner"] == "post":
            part["place"]["translation"] = [0.5, 0.0, 0.1]
    assert "post" in checker.fault(proven.write(tmp_path / "x.proof"))


def test_parts_next_to_the_arm_are_finer_than_others(tmp_path: Path, checker: Checker) -> None:
    """The arm turns in a ring of balls, which no coarse part clears."""
    angles = np.linspace(0.0, 2.0 * np.pi, 200)
    ring = np.stack((1.02 * np.cos(angles), 1.02 * np.sin(angles), np.full(200, 0.14)), axis=1)
    ring = np.concatenate((ring, ring + np.array((0.0, 0.0, 3.0))))
    scene = to.Scene(to.load("planar2")).add("ring", to.Points(ring, 0.015))
    start, goal = {"joint1": -0.4, "joint2": 0.0}, to.joint_positions({"joint1": 0.4, "joint2": 0.0})
    found = planned(to.Problem(scene=scene, start=start, goal=goal, name="ring"), tmp_path / "x.proof")
    groups = [len(centres) for _, centres in cloud(found.statement)["inside"]]
    assert sum(groups) == 400
    assert min(groups) < 10
    assert max(groups) >= 50
    assert checker.fault(tmp_path / "x.proof") == ""
    assert list(refuted(found.statement)) == []


def test_a_cloud_in_the_hand_is_proven(tmp_path: Path, checker: Checker) -> None:
    """Both sides of its pairs are clouds."""
    held = to.Points(np.array([(0.0, 0.0, z) for z in np.linspace(-0.02, 0.02, 9)]), 0.005)
    problem = past(measured_post())
    scene = problem.scene.add("held", held, to.placement((0.0, 0.0, 0.0)), frame="tool").allow(
        "held", "link2"
    )
    found = planned(replace(problem, scene=scene), tmp_path / "x.proof")
    assert {each["owner"] for each in of_kind(found.statement, "cloud")} == {"post", "held"}
    assert checker.fault(tmp_path / "x.proof") == ""
    assert list(refuted(found.statement)) == []


def test_a_proof_of_another_cloud_differs() -> None:
    problem, above = past(measured_post()), measured_post().points + np.array((0.0, 0.0, 1e-4))
    motion = to.plan(problem).require().trajectory
    proven = proof.prove(problem, motion)
    assert proven.differs_from(problem, motion) == ""
    assert proven.differs_from(past(to.Points(above, RADIUS)), motion) == "clouds"


def test_a_cloud_that_is_too_large_for_a_file_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = past(measured_post())
    monkeypatch.setattr(proof, "LARGEST", 10_000)
    with pytest.raises(ProblemError, match=r"at most 10000 bytes, and this one needs \d+: thin the clouds"):
        proof.prove(problem, to.plan(problem).require().trajectory)

"""Exclusion proofs: what one configuration holds together is never said to exclude each other."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.planning.infeasibility import exclusion
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model

UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def point(where: to.Placement) -> to.Requirement:
    return to.frame_placement("tip", where, rotation_tolerance=np.inf, position_tolerance=0.0)


@pytest.fixture(scope="module")
def reduced(tmp_path_factory: pytest.TempPathFactory) -> ReducedModel:
    folder: Path = tmp_path_factory.mktemp("robot")
    robot = odd_arm(folder)
    scene = to.Scene(robot).add(
        "cup", to.Sphere(0.02), to.placement((0.1, 0.0, 0.05), rpy=(0.3, 0, 1)), frame="tip"
    )
    return reduce_model(scene, "all", robot.positions({}))


def held_at(reduced: ReducedModel, q: np.ndarray, rng: np.random.Generator) -> list[to.Requirement]:
    """Requirements that a configuration holds, each just so."""
    found: list[to.Requirement] = [
        to.joint_positions({"pan": q[0] + 0.01, "elbow": q[2] - 0.02}, tolerance=0.0201),
        to.joint_positions({"elbow": q[2] + 0.1}, below={"elbow": 0.1001}, above={"elbow": 0.0}),
    ]
    for frame in ("tip", "cup"):
        where = reduced.scene.placement_of(frame, reduced.all_positions(q))
        axis, off = rng.normal(size=3), rng.normal(size=3)
        axis, off = axis / np.linalg.norm(axis), 0.05 * off
        aside = np.cross(axis, rng.normal(size=3))
        angle = rng.uniform(0.05, 1.0)
        turned = to.placement(rpy=tuple(0.1 * rng.normal(size=3)))
        tilted = np.cos(angle) * axis + np.sin(angle) * aside / np.linalg.norm(aside)
        found += [
            to.axis_alignment(frame, axis=axis, direction=where.rotation @ tilted, tolerance=angle + 1e-6),
            to.frame_placement(
                frame,
                to.placement(where.translation) * to.placement(rpy=(0, 0, 0)),
                position_tolerance=1e-4,
                rotation_tolerance=np.inf,
            ),
            to.frame_placement(
                frame,
                to.Placement(where.rotation @ turned.rotation, where * off),
                position_tolerance=0.3,
                rotation_tolerance=0.5,
            ),
            to.position_in_region(
                frame, to.Box(0.2, 0.1, 0.1), to.placement(where * off + [0.04, 0, 0]), offset=off
            ),
        ]
    return found


@pytest.mark.parametrize("seed", range(12))
def test_compatible_requirements_are_not_excluded(reduced: ReducedModel, seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, 4) * (1.0, 0.0, 1.0, 1.0) + (0.0, 0.1, 0.0, 0.0)
    for first, second in combinations(held_at(reduced, q, rng), 2):
        assert exclusion(first, second, reduced) == "", f"{first} and {second}"


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        (
            to.axis_alignment("tip", direction=UP, tolerance=0.3),
            to.axis_alignment("tip", direction=DOWN, tolerance=0.3),
            "145.6 deg",
        ),
        (
            to.axis_alignment("tip", direction=UP, tolerance=0.5),
            to.axis_alignment("cup", axis=UP, direction=DOWN, tolerance=0.5),
            "deg",
        ),
        (
            to.frame_placement("tip", to.placement(rpy=(np.pi, 0, 0)), position_tolerance=np.inf),
            to.axis_alignment("tip", direction=UP, tolerance=0.2),
            "deg",
        ),
        (
            to.frame_placement("tip", to.placement(rpy=(0.5, 0, 0)), position_tolerance=np.inf),
            to.frame_placement("tip", to.placement(), position_tolerance=np.inf),
            "28.4 deg",
        ),
        (
            point(to.placement((0.5, 0, 0))),
            point(to.placement((0.4, 0, 0))),
            "100.0 mm",
        ),
        (
            point(to.placement((0.5, 0, 0))),
            to.position_in_region("tip", to.Box(0.2, 0.2, 0.2)),
            "400.0 mm",
        ),
        (
            to.position_in_region("tip", to.Plane(), to.placement((0.0, 0.0, 0.2))),
            point(to.placement((0, 0, 0.5))),
            "300.0 mm",
        ),
        (
            to.joint_positions({"pan": 0.1}, tolerance=0.05),
            to.joint_positions({"pan": 0.4}, tolerance=0.05),
            "11.46 deg farther apart",
        ),
    ],
    ids=lambda value: str(value)[:24],
)  # fmt: skip
def test_contradicting_requirements_are_proven(
    reduced: ReducedModel, first: to.Requirement, second: to.Requirement, words: str
) -> None:
    assert words in exclusion(first, second, reduced)
    assert words in exclusion(second, first, reduced)


def test_different_bodies_are_not_a_proof(reduced: ReducedModel) -> None:
    first = to.axis_alignment("tip", direction=UP, tolerance=0.3)
    second = to.axis_alignment("fore", direction=DOWN, tolerance=0.3)
    assert exclusion(first, second, reduced) == ""

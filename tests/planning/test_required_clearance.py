"""A required clearance is kept by planned motions, and what cannot keep it is refused by name."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.verify.arms import joint, link, planar_arm, robot
from trajopt.planning.infeasibility import closed_cut
from trajopt.planning.status import Certainty

RADIUS = 0.05


def slide(folder: Path) -> to.Robot:
    """Two slides, along x and y."""
    return robot(
        folder,
        link("base"),
        link("rail"),
        link("hand"),
        joint("x", "base", "rail", kind="prismatic", axis="1 0 0"),
        joint("y", "rail", "hand", kind="prismatic", axis="0 1 0"),
    )


def ball_over_box(folder: Path, gap: float) -> to.Scene:
    """A ball on the slides, so far above a box at x = y = 0 [m]."""
    scene = to.Scene(slide(folder), margin=0.0)
    scene = scene.add("ball", to.Sphere(RADIUS), frame="hand", touch_links=["hand"])
    return scene.add("box", to.Box(0.2, 0.2, 0.2), to.placement((0.0, 0.0, -0.1 - RADIUS - gap)))


@pytest.mark.parametrize(
    ("gap", "required", "certainty"),
    [
        (1e-7, 0.0, Certainty.EVIDENCE),
        (9e-7, 0.0, Certainty.EVIDENCE),
        (-1e-7, 0.0, Certainty.EVIDENCE),
        (-1e-4, 0.0, Certainty.PROVEN),
        (0.02 + 1e-7, 0.02, Certainty.EVIDENCE),
        (0.02 - 1e-4, 0.02, Certainty.PROVEN),
    ],
)
def test_a_violation_below_the_distance_error_is_not_proven(
    tmp_path: Path, gap: float, required: float, certainty: Certainty
) -> None:
    scene = ball_over_box(tmp_path, gap).with_clearance(required)
    away, there = {"x": 0.5, "y": 0.0}, {"x": 0.0, "y": 0.0}
    for start, goal, status in (
        (there, away, to.Status.START_IN_COLLISION),
        (away, there, to.Status.GOAL_IN_COLLISION),
    ):
        exactly = to.joint_positions(goal, tolerance=0.0)
        result = to.plan(to.Problem(scene=scene, start=start, goal=exactly))
        assert result.status is status and result.certainty is certainty
        explained = result.explain()
        assert explained.certainty is certainty
        assert ("less than the distance may err" in explained.grounds) == (certainty is Certainty.EVIDENCE)
        assert "0.0 mm inside" not in result.message


def test_a_start_over_a_micrometre_clear_does_not_collide(tmp_path: Path) -> None:
    problem = to.Problem(
        scene=ball_over_box(tmp_path, 1.1e-6), start={}, goal=to.joint_positions({"x": 0.5, "y": 0.0})
    )
    assert to.plan(problem).status is not to.Status.START_IN_COLLISION


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.array, int])
def test_meant_contact_takes_any_number(tmp_path: Path, kind: type) -> None:
    scene = ball_over_box(tmp_path, -5e-4)
    leaving = scene.allow_contact("lift off", "ball", "box", depth=kind(1), first=kind(1), last=kind(1))
    plain = scene.allow_contact("lift off", "ball", "box", depth=1.0, first=1.0, last=1.0)
    assert leaving.allowances == plain.allowances
    result = to.plan(to.Problem(scene=leaving, start={}, goal=to.joint_positions({"x": 0.5, "y": 0.0})))
    assert result.verified and result.certificate is not None
    assert any(check.name == "contact: lift off" for check in result.certificate.checks)
    assert type(leaving.with_margin(kind(0)).margin) is float


ROD, HALF = 0.5, 0.01
"""Length and half the width of the planar arm's two rods [m]."""
BUDGET = 40_000
"""Configurations that a plan of the random family may look at."""


def rods_apart(positions: np.ndarray, centre: np.ndarray, radius: float) -> np.ndarray:
    """Distance of each rod from a ball in the arm's plane, by hand: (S, 2) -> (S, 2) [m]."""
    angles = np.cumsum(positions, axis=1)
    elbow = ROD * np.stack((np.cos(angles[:, 0]), np.sin(angles[:, 0])), axis=1)
    origins = np.stack((np.zeros_like(elbow), elbow), axis=1)
    seen = centre - origins
    along = np.cos(angles) * seen[..., 0] + np.sin(angles) * seen[..., 1]
    across = np.cos(angles) * seen[..., 1] - np.sin(angles) * seen[..., 0]
    beyond = np.maximum(np.abs(along - ROD / 2) - ROD / 2, 0.0)
    return np.hypot(beyond, np.maximum(np.abs(across) - HALF, 0.0)) - radius


class Family:
    """Random problems of the planar arm among balls, each with a clearance of its own from each rod."""

    def __init__(self, folder: Path, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.scene = to.Scene(planar_arm(folder), margin=float(rng.choice((0.0, 0.01, 0.03))))
        self._draw(rng)
        # Of every second one the straight line does not keep what is required.
        while not (self._ends_free() and (seed % 2 or self._line().min() < 0.0)):
            self._draw(rng)
        for number, ((centre, radius), required) in enumerate(zip(self.balls, self.required, strict=True)):
            name = f"ball{number}"
            self.scene = self.scene.add(name, to.Sphere(radius), to.placement((*centre, 0.0)))
            for rod, value in zip(("upper", "lower"), required, strict=True):
                self.scene = self.scene.with_clearance(value, rod, name)

    def _draw(self, rng: np.random.Generator) -> None:
        far, angle = rng.uniform(0.55, 0.9, 2), rng.uniform(-np.pi, np.pi, 2)
        centres = far[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
        self.balls = list(zip(centres, rng.uniform(0.02, 0.06, 2).tolist(), strict=True))
        self.required = rng.choice((0.0, 0.02, 0.05), (2, 2)).tolist()
        self.start, self.goal = rng.uniform(-2.0, 2.0, (2, 2))

    def _line(self) -> np.ndarray:
        return self.spare(np.linspace(self.start, self.goal, 200))

    def _ends_free(self) -> bool:
        return bool(self._line()[[0, -1]].min() > 0.01)

    def spare(self, positions: np.ndarray) -> np.ndarray:
        """Distance beyond what is required of each rod and ball at configurations, (S, 2) -> (S, 6) [m]."""
        apart = [rods_apart(positions, *ball) for ball in self.balls]
        return np.concatenate(apart, axis=1) - np.ravel(self.required)

    @property
    def problem(self) -> to.Problem:
        start, goal = (
            dict(zip(("shoulder", "elbow"), map(float, at), strict=True)) for at in (self.start, self.goal)
        )
        return to.Problem(scene=self.scene, start=start, goal=to.joint_positions(goal, tolerance=0.0))


def test_planned_motions_keep_the_required_clearance(tmp_path: Path) -> None:
    bent, solved = 0, 0
    for seed in range(60):
        family = Family(tmp_path, seed)
        result = to.plan(family.problem, budget=to.Budget(work=BUDGET))
        assert "IN_COLLISION" not in result.status.name
        if not result.verified:
            continue
        solved += 1
        motion = result.trajectory
        assert motion is not None and result.certificate is not None
        along = motion(np.linspace(0.0, motion.duration, 5001))
        spare = family.spare(along).min(axis=0)
        assert spare.min() >= 0.0, (seed, spare)
        bent += seed % 2 == 0
        rows = [check for check in result.certificate.checks if check.name == "clearance"]
        assert {row.bound for row in rows} == set(np.ravel(family.required))
        for row in rows:
            mine = np.ravel(family.required) == row.bound
            assert row.value is not None and row.bound is not None
            assert row.bound <= row.value <= spare[mine].min() + row.bound + 1e-4
    assert solved >= 30 and bent >= 5, (solved, bent)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("end", ["start", "goal"])
def test_an_end_within_it_is_refused_by_name(tmp_path: Path, seed: int, end: str) -> None:
    family = Family(tmp_path, seed)
    angle = float(np.sum(getattr(family, end)))
    shoulder = float(getattr(family, end)[0])
    elbow = ROD * np.array((np.cos(shoulder), np.sin(shoulder)))
    tip = elbow + ROD * np.array((np.cos(angle), np.sin(angle)))
    near = tip + (0.03 + 0.017) * np.array((np.cos(angle), np.sin(angle)))
    scene = family.scene.add("person", to.Sphere(0.03), to.placement((*near, 0.0)))
    family.scene = scene.with_clearance(0.02, "lower", "person")
    other = np.stack((family.goal if end == "start" else family.start,))
    assert rods_apart(other, near, 0.03).min() > 0.03, "the other end is free"
    result = to.plan(family.problem)
    assert result.status.name == f"{end.upper()}_IN_COLLISION" and result.certainty is Certainty.PROVEN
    assert "lower" in result.message and "person" in result.message
    assert "17.0 mm from" in result.message and "20 mm are required" in result.message


def gap(folder: Path, spare: float) -> to.Scene:
    """A ball on two slides, and a wall across them with an opening that leaves so much on both sides [m]."""
    scene = to.Scene(slide(folder), margin=0.0)
    scene = scene.add("ball", to.Sphere(RADIUS), frame="hand", touch_links=["hand"])
    for name, sign in (("left", 1.0), ("right", -1.0)):
        at = to.placement((0.0, sign * (RADIUS + spare + 2.0), 0.0))
        scene = scene.add(name, to.Box(0.02, 4.0, 0.4), at)
    return scene


@pytest.mark.parametrize("seed", range(8))
def test_only_the_required_clearance_closes_a_gap(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    spare = float(rng.uniform(0.008, 0.04))
    start, goal = {"x": -0.4, "y": float(rng.uniform(-0.3, 0.3))}, {"x": 0.4, "y": 0.0}

    def planned(required: float) -> to.Result:
        scene = gap(tmp_path, spare).with_clearance(required)
        return to.plan(to.Problem(scene=scene, start=start, goal=to.joint_positions(goal)))

    assert planned(0.0).verified, "it is passable where nothing is required"
    assert planned(spare - 0.006).verified, "and with as much as leaves the optimiser its room"
    closed = planned(spare + 0.002)
    assert closed.status is to.Status.PROVEN_INFEASIBLE and closed.certainty is Certainty.PROVEN
    assert f"nearer than the required {1000 * (spare + 0.002):g} mm" in closed.message
    # With a little less than the gap leaves, a motion is known: no proof may say that there is none.
    scene = gap(tmp_path, spare).with_clearance(spare - 5e-4)
    problem = to.Problem(scene=scene, start={**start, "y": 0.0}, goal=to.joint_positions(goal))
    middle = to.Trajectory(
        ("x", "y"),
        np.array([0.0, 4.0]),
        np.array([[-0.4, 0.0], [0.4, 0.0]]),
        np.zeros((2, 2)),
        np.zeros((2, 2)),
    )
    known = [check for check in to.judge(problem, middle).checks if check.name == "clearance"]
    assert all(check.holds for check in known)
    assert closed_cut(problem) is None
    assert to.plan(problem).status is not to.Status.PROVEN_INFEASIBLE

"""Objects that move, appear and expire are in a proof, with the errors of their tracks."""

import copy
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trajopt as to
from tests.files.proof.conftest import Checker, Document, Proof, planar_problem
from tests.files.proof.dense import curve, placed, refuted
from tests.files.proof.test_attacks import WHOLE, one_joint
from tests.files.proof.test_bounds import arm
from trajopt.files.proof import save_proof
from trajopt.values.errors import ProblemError

Numbers = np.ndarray


def test_moving_objects_are_proven(tmp_path: Path, checker: Checker, moving: Proof) -> None:
    path = moving.write(tmp_path / "x.proof")
    words, fault = checker.examined(path)
    assert fault == ""
    assert list(refuted(moving.statement)) == []
    assert moving.statement["judged"] == []
    owners = [part["owner"] for part in moving.statement["parts"]]
    paired = {owners[part] for pair in moving.statement["pairs"] for part in pair[:2]}
    assert {"bar", "leaving", "coming"} <= paired
    assert "bar is there from -inf to inf s, within 0.002 + 0.003 t + 0.0005 t^2 m" in words


FALSE: dict[str, tuple[Callable[[Document], object], str]] = {
    "a larger error": (lambda s: change(s, "bar")[3].__setitem__(0, 0.3), "bar"),
    "an error that grows": (lambda s: change(s, "bar")[3].__setitem__(1, 0.3), "bar"),
    "a ball that stays": (lambda s: change(s, "leaving").__setitem__(2, None), "leaving"),
    "a ball that comes early": (lambda s: change(s, "coming").__setitem__(1, None), "coming"),
    "a track elsewhere": (lambda s: shift(s["drives"][0]["values"][0], -0.1), "bar"),
    "a larger bar": (lambda s: grow(s, "bar"), "bar"),
    "a track that ends early": (lambda s: s["drives"][0]["times"].__setitem__(-1, 1.0), "until its end"),
    "a track that starts late": (lambda s: s["drives"][0]["times"].__setitem__(0, 0.1), "from 0"),
    "a pair left out": (lambda s: s["pairs"].pop(), ""),
}


def change(statement: Document, owner: str) -> list[Any]:
    return next(each for each in statement["changes"] if each[0] == owner)


def shift(positions: Any, by: float) -> None:
    for place in positions:
        place[0] += by


def grow(statement: Document, owner: str) -> None:
    for part in statement["parts"]:
        if part["owner"] == owner:
            part["shape"]["radius"] += 0.3


@pytest.mark.parametrize("name", FALSE)
def test_a_false_statement_is_refused(name: str, tmp_path: Path, checker: Checker, moving: Proof) -> None:
    make_false, words = FALSE[name]
    statement = copy.deepcopy(moving.statement)
    make_false(statement)
    try:
        fault = checker.fault(Proof(statement, moving.witness).write(tmp_path / "x.proof"))
    except checker.malformed as error:
        fault = str(error)
    assert fault and words in fault


def sliding_box(gap: float, velocities: tuple[float, float]) -> Document:
    """A ball at rest and a box, which slides along x with one velocity until 0.5 s and then another."""
    statement = copy.deepcopy(one_joint(gap))
    statement["parts"][1]["place"] = {**statement["parts"][1]["place"], "joint": 2}
    slider = {**statement["joints"][0], "name": "slider", "turns": False, "axis": [1, 0, 0], "coordinate": 1}
    statement["joints"].append(slider)
    (one, other), half = velocities, velocities[0] / 2.0
    values = [[[0.0], [half], [half], [half + other / 2.0]], [[one], [one], [other], [other]]]
    statement["drives"] = [{"coordinates": ["x"], "times": [0, 0.5, 0.5, 1], "values": values}]
    return statement


HALVES = struct.pack("<IIHhhhHhhh", 0, 2, 0, 1, 0, 0, 1, 1, 0, 0)
"""Two leaves along x, which meet at 0.5 s."""


def test_no_leaf_reaches_across_a_knot(tmp_path: Path, checker: Checker) -> None:
    """The box has no acceleration in its pieces, but passes through the ball between the ends of the leaf."""
    there_and_back = sliding_box(0.1, (-1.0, 1.0))
    fault = checker.fault(Proof(there_and_back, WHOLE).write(tmp_path / "x.proof"))
    assert "across a knot" in fault
    assert "not shown" in checker.fault(Proof(there_and_back, HALVES).write(tmp_path / "x.proof"))
    away = sliding_box(0.1, (1.0, 2.0))
    assert "across a knot" in checker.fault(Proof(away, WHOLE).write(tmp_path / "x.proof"))
    assert checker.fault(Proof(away, HALVES).write(tmp_path / "x.proof")) == ""


def test_a_jump_at_a_knot_counts_on_both_sides(tmp_path: Path, checker: Checker) -> None:
    for before, after in ((-0.2, 0.0), (0.0, -0.2)):
        statement = sliding_box(0.1, (0.0, 0.0))
        (drive,) = statement["drives"]
        drive["values"][0] = [[0.0], [before], [after], [0.0]]
        fault = checker.fault(Proof(statement, HALVES).write(tmp_path / "x.proof"))
        assert "not shown" in fault


@pytest.mark.parametrize(("error", "gap"), [([0.1, 0, 0], 0.1), ([0, 0.1, 0], 0.1), ([0, 0, 0.2], 0.1)])
def test_errors_of_tracks_are_kept_clear(
    error: list[float], gap: float, tmp_path: Path, checker: Checker
) -> None:
    for off, proven in ((1e-9, True), (-1e-9, False)):
        statement = one_joint(gap + off)
        statement["changes"] = [["box", None, None, error]]
        assert (checker.fault(Proof(statement, WHOLE).write(tmp_path / "x.proof")) == "") == proven


def test_only_present_objects_are_kept_clear(tmp_path: Path, checker: Checker) -> None:
    statement = one_joint(-0.1)
    for appears, expires, proven in (
        (1.0, None, True), (2.0, None, True), (0.99, None, False), (None, 0.0, True), (None, 0.01, False),
    ):  # fmt: skip
        statement["changes"] = [["box", appears, expires, [0, 0, 0]]]
        assert (checker.fault(Proof(statement, WHOLE).write(tmp_path / "x.proof")) == "") == proven


def test_pairs_that_the_robot_moves_must_be_there(tmp_path: Path, checker: Checker) -> None:
    statement = sliding_box(0.1, (1.0, 1.0))
    other = {**copy.deepcopy(statement["parts"][1]), "owner": "wall"}
    other["place"]["joint"] = 0
    statement["parts"].append(other)
    statement["excused"] = [["ball", "wall", "far away"]]
    assert checker.fault(Proof(statement, HALVES).write(tmp_path / "x.proof")) == ""
    statement["pairs"] = []
    empty = struct.pack("<I", 0)
    assert "ball and box are neither" in checker.fault(Proof(statement, empty).write(tmp_path / "x.proof"))


def test_a_drive_has_no_limit_of_jerk(tmp_path: Path, checker: Checker) -> None:
    statement = sliding_box(0.1, (1.0, 1.0))
    statement["joints"][1]["jerk"] = 1.0
    with pytest.raises(checker.malformed, match="follows time"):
        checker.fault(Proof(statement, HALVES).write(tmp_path / "x.proof"))


def driven_arm(rng: np.random.Generator, degree: int) -> Document:
    """The odd tree of joints; its last coordinate follows time, with jumps at its knots."""
    stated = arm(rng, 5)
    motion = stated["motion"]
    motion["coordinates"] = motion["coordinates"][:3]
    motion["values"] = [[row[:3] for row in rows] for rows in motion["values"]]
    for name in ("positions", "velocities", "accelerations"):
        stated["ends"][name] = [0.0] * 3
    values = rng.uniform(-1.0, 1.0, ((degree + 1) // 2, 6, 1)).tolist()
    stated["drives"] = [{"coordinates": ["d"], "times": [0.0, 0.6, 0.6, 1.3, 1.3, 2.5], "values": values}]
    return stated


@pytest.mark.parametrize("degree", [3, 5])
def test_drives_are_bounded(degree: int, checker: Checker) -> None:
    stated = driven_arm(np.random.default_rng(degree), degree)
    statement = checker.modules["statement"].read_statement(stated)
    grid = np.unique(np.concatenate((stated["motion"]["times"], [0.6, 1.3], np.linspace(0.0, 2.0, 25))))
    with np.errstate(all="ignore"):  # the pieces of length zero at jumps, which no cell uses
        found = checker.modules["kinematics"].GridKinematics(statement, grid)
    for times in (np.nextafter(grid[1:], -1.0), np.nextafter(grid[:-1], 9.0)):
        places = found.rotation[1:] if times[0] > 0.01 else found.rotation[:-1]
        turns, _ = placed(stated, times)
        assert (places.low - 1e-12 <= turns).all() and (turns <= places.high + 1e-12).all()
    for order, bound in enumerate(found.motion.bounds):
        for share in np.linspace(0.001, 0.999, 9):
            value = curve(stated)(grid[:-1] + share * np.diff(grid), order)
            slack = 1e-9 * (1.0 + np.abs(value))
            assert (bound.low - slack <= value).all() and (value <= bound.high + slack).all()
    begin, local = np.arange(len(grid) - 1), np.array((0.1, 0.2, 0.3))
    intervals = checker.modules["intervals"]
    path = found.translation[:, 5] + intervals.turned(found.rotation[:, 5], intervals.exactly(local))
    travel = found.travel(5, path, 0.0, begin, begin + 1, np.zeros_like(begin))
    for place in begin.tolist():
        ends = grid[place] + np.array((1e-6, 1.0 - 1e-6)) * (grid[place + 1] - grid[place])
        times, step = np.linspace(*ends, 12, retstep=True)
        turns, origins = placed(stated, times)
        world = origins[:, 5] + turns[:, 5] @ local
        for order, bound in enumerate((travel.velocity, travel.acceleration), start=1):
            sizes = np.linalg.norm(np.diff(world, order, axis=0) / step**order, axis=1)
            assert sizes.max() <= bound[place] * (1.0 + 1e-6) + 1e-5


def test_a_track_with_too_many_turns_has_no_proof(tmp_path: Path, planar_plan: to.Plan) -> None:
    """Each piece of a track with a turn of its own is a joint."""
    places = [to.placement((0.0, 0.0, 9.0), rpy=(0.1 * np.sin(k), 0.1 * np.cos(k), 0.0)) for k in range(1000)]
    track = to.Track.through(np.linspace(0.0, 9.0, 1000), places)
    problem = planar_problem()
    tumbling = problem.scene.add("tumbling", to.Box(0.1, 0.1, 0.1), motion=track)
    with pytest.raises(ProblemError, match="fewer than 1000 joints, and the tracks of the scene need 1004"):
        save_proof(replace(problem, scene=tumbling), planar_plan.trajectory, tmp_path / "x.proof")
    assert not (tmp_path / "x.proof").exists()

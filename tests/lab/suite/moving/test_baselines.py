"""What ours is compared with among what moves does what it says, and the tables count what came."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from benchmarks.moving.__main__ import drop, finished, unsettled
from benchmarks.moving.crossings import BOX, Crossing
from benchmarks.moving.fixed_links import first_touch, least_time, why_not
from benchmarks.moving.report import Report
from benchmarks.moving.waiting import waited
from benchmarks.workers import Key

START, GOAL = {"joint1": -1.0, "joint2": 0.3}, {"joint1": 1.0, "joint2": 0.3}
FAST = 0.5


def still() -> to.Problem:
    scene = to.Scene(to.load("planar2"))
    return to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL))


def crossing(problem: to.Problem, place: to.Placement, velocity: tuple[float, float, float]) -> Crossing:
    duration = to.plan(problem).require().trajectory.duration
    at = tuple(place.translation.tolist())
    return Crossing(
        "x/y/1", (0.1, 0.1, 0.1), (0.0, 0.0, 0.0, 1.0), at, velocity, duration / 2.0, duration, "link"
    )


def hand_at(problem: to.Problem, motion: to.Trajectory, time: float) -> to.Placement:
    reduced = problem.reduced
    return problem.scene.placement_of(problem.scene.robot.links[-1], reduced.all_positions(motion(time)))


def test_waiting_lasts_until_the_box_has_passed() -> None:
    problem = still()
    motion = to.plan(problem).require().trajectory
    box = crossing(problem, hand_at(problem, motion, motion.duration / 2.0), (0.0, 0.0, FAST))
    among = box.add_to(problem)
    assert not to.judge(among, motion).verified
    wait = waited(among, box, motion)
    assert wait is not None and box.moment < wait < box.moment + 1.0
    at_start = crossing(problem, hand_at(problem, motion, 0.0), (0.0, 0.0, FAST))
    assert waited(at_start.add_to(problem), at_start, motion) is None


def test_waiting_fails_if_the_box_meets_the_base_before_the_end() -> None:
    problem = still()
    motion = to.plan(problem).require().trajectory
    hand = hand_at(problem, motion, motion.duration / 2.0)
    to_base = -hand.translation / np.linalg.norm(hand.translation)
    # Through the hand at the moment of the crossing, on to the base, and through that.
    box = crossing(problem, hand, tuple((FAST * to_base).tolist()))
    touched = first_touch(problem, box)
    assert touched is not None and touched > box.moment
    nearly = first_touch(problem, box, near=0.1)
    assert nearly is not None and nearly < touched
    assert waited(box.add_to(problem), box, motion) is None
    assert least_time(problem) == pytest.approx(2.0 / problem.limits.velocity[0])
    sooner = replace(box, moment=box.moment - touched)
    assert first_touch(problem, sooner) == pytest.approx(0.0, abs=2e-3)
    assert "touches a link that no joint moves" in (why_not(problem, sooner) or "")
    late = replace(box, moment=box.moment + least_time(problem))
    assert why_not(problem, late) is None, "a motion may be over before"
    assert first_touch(problem, crossing(problem, hand, (0.0, 0.0, FAST))) is None


def test_the_judge_proves_motions_of_the_space_time_rrt() -> None:
    pytest.importorskip("ompl", exc_type=ImportError)
    from benchmarks.moving.space_time_rrt import SpaceTimeRrt

    problem = still()
    motion = to.plan(problem).require().trajectory
    box = crossing(problem, hand_at(problem, motion, motion.duration / 2.0), (0.0, 0.0, FAST))
    rrt = SpaceTimeRrt(box.add_to(problem), latest=10.0)
    found = rrt.solve(20.0).trajectory
    assert found is not None and found.duration >= rrt.least
    assert BOX in rrt.problem.scene.changing
    points = found(np.array((0.0, found.duration)))
    assert points == pytest.approx(np.array((list(START.values()), list(GOAL.values()))), abs=1e-9)
    limits = problem.limits.velocity
    assert (np.abs(np.diff(found.positions, axis=0)) <= limits * np.diff(found.times)[:, None] + 1e-9).all()
    resting = SpaceTimeRrt(box.add_to(problem), latest=20.0, resting=True).solve(20.0).trajectory
    assert resting is not None and to.judge(rrt.problem, resting).verified
    rrt.goal = rrt.start + 1e-3
    rrt.latest = 0.0
    assert rrt.solve(0.1).trajectory is None, "nothing ends before it can"


def row(family: str, number: int, **said: object) -> dict[str, object]:
    key = {"key": f"{family}-{number}", "family": family, "seed": number}
    return {**key, "outcome": "done", "commit": "abc1234", **said}


def planned(cpu: float, duration: float | None) -> dict[str, object]:
    return {"cpu": cpu, "duration": duration, "verified": duration is not None, "status": "any"}


def test_the_tables_count_known_motions() -> None:
    keys: list[Key] = [("crossing/panda/box", number) for number in range(1, 6)]
    rooms: list[Key] = [("cubes/10", 0), ("cubes/10", 1)]
    rows = [
        row("crossing/panda/box", 1, still=planned(0.02, 1.0), ours=planned(0.04, 1.1), wait=1.2),
        row("crossing/panda/box", 2, still=planned(0.02, 1.0), ours=planned(0.08, None), wait=0.5),
        row("crossing/panda/box", 3, still=planned(0.02, 1.0), ours=planned(9.0, None), wait=None),
        row("crossing/panda/box", 4, still=planned(0.02, 1.0), ours=planned(0.08, None), wait=None),
        row("crossing/panda/box", 5) | {"outcome": "crash"},
        row("known/panda/box", 3, rrt={"duration": 2.0}, resting={"duration": None}),
        row("known/panda/box", 4, rrt={"duration": 3.0}, resting={"duration": 3.0}),
        row("best/panda/box", 1, seconds=60.0, rrt={"duration": 1.0}),
        row("best/panda/box", 2, seconds=20.0, rrt={"duration": None}),
        row("cubes/10", 0, ours=planned(0.1, 2.0), rrt={"duration": 4.0}),
        row("cubes/10", 1, ours=planned(0.1, None), rrt={"duration": 4.0}, resting={"duration": 5.0}),
    ]
    report = Report({str(each["key"]): each for each in rows}, keys, rooms)
    text = report.text()
    assert (
        "| Panda | 5 | 3 | 1 | 33.3 % | 1 | 1 | 0 | 20 / 20 | 80 / 80 | 4.0 | 4.0 | 40 / 40 | 1.10 |" in text
    )
    assert "Known but not proven: panda/box/2, panda/box/4." in text
    assert "| Panda | 60 | 1 | 1 | 1 | 1.10 / 1.10 / 1.10 | 100.0 % | 1 | 0.50 | 0.45 |" in text
    assert "| Panda | 20 | 1 | 0 | 0 |" in text
    assert "| 10 | 2 | 1 | 50.0 % | 100 / 100 | 2 | 100.0 % | 2 | 1 | 0 | 0.50 |" in text
    assert "UR5" not in text and len(report.rows) == len(rows)
    assert Report({}, keys, rooms).text() == ""


def test_parts_are_measured_again(tmp_path: Path) -> None:
    file = tmp_path / "rows.jsonl"
    drop(file, ["cubes"])
    assert file.read_text() == ""
    file.write_text("".join(f"{json.dumps(row(name, 1))}\n" for name in ("cubes/10", "best/panda/box")))
    drop(file, ["cubes", "crossing"])
    assert [json.loads(line)["family"] for line in file.read_text().splitlines()] == ["best/panda/box"]


def test_the_baseline_runs_only_on_open_problems() -> None:
    def asked(certainty: str, wait: float | None, duration: float | None) -> bool:
        ours = planned(0.1, duration) | {"certainty": certainty}
        return unsettled(row("crossing/panda/box", 1, ours=ours, wait=wait))

    assert asked("EVIDENCE", None, None)
    assert not asked("PROVEN", None, None), "there is none, and that is proven"
    assert not asked("EVIDENCE", 0.5, None) and not asked("PROVEN", None, 1.0) and not unsettled(None)
    died = row("known/panda/box", 1) | {"outcome": "crash"}
    assert finished(row("known/panda/box", 1)) and not finished(died) and not finished(None)

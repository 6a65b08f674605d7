"""Picking and placing ends when its budget does, or when it is cancelled, and tells how far it is."""

from threading import Event
from typing import Any

import pytest

import trajopt as to
from trajopt.planning import Budget, Status, Stop
from trajopt.tasks.grasping import (
    Gripper,
    Place,
    grasps_of,
    pick,
    pick_and_place,
    place,
)
from trajopt.values.errors import PlanningFailed, ProblemError

from .conftest import BLOCK, FUNCTIONS, STOOD, on_table


def task(panda: to.Robot, gripper: Gripper) -> dict[str, Any]:
    """Arguments of a pick and place that has a solution."""
    scene = on_table(panda, BLOCK, STOOD)
    grasps = grasps_of(scene, "thing", gripper)
    places = Place(placement=FUNCTIONS)
    return {"scene": scene, "name": "thing", "start": "ready", "grasps": grasps, "places": places}


def test_a_budget_of_one_work_unit_ends_planning_immediately(panda: to.Robot, gripper: Gripper) -> None:
    carried = pick_and_place(**task(panda, gripper), budget=Budget(work=1))
    assert carried.status is Status.OUT_OF_WORK and carried.stopped is Stop.WORK
    assert not carried.verified and carried.segments == () and carried.refusals == ()
    assert "qp_solves" not in carried.counts
    assert str(carried.explain()).startswith("OUT_OF_WORK") and "not finished" in str(carried.explain())
    with pytest.raises(PlanningFailed, match="OUT_OF_WORK"):
        carried.require()


def test_the_budget_is_for_the_whole_sequence(panda: to.Robot, gripper: Gripper) -> None:
    """Work that is enough for the first motions ends the search in a later one, and is all counted."""
    whole = pick_and_place(**task(panda, gripper))
    work = whole.counts["forward_kinematics"]
    assert work > sum(item.result.counts["forward_kinematics"] for item in whole.segments)
    again = pick_and_place(**task(panda, gripper), budget=Budget(work=work + 1))
    assert again.verified and again.counts == whole.counts
    less = pick_and_place(**task(panda, gripper), budget=Budget(work=9 * work // 10))
    assert less.status is Status.OUT_OF_WORK and "qp_solves" in less.counts
    assert less.counts["forward_kinematics"] < work


def test_time_ends_it(panda: to.Robot, gripper: Gripper) -> None:
    ticks = iter(range(10**9))
    carried = pick_and_place(
        **task(panda, gripper), budget=Budget(seconds=4.0, clock=lambda: float(next(ticks)))
    )
    assert carried.status is Status.OUT_OF_TIME and carried.stopped is Stop.CLOCK


@pytest.mark.parametrize("verb", [pick, pick_and_place])
def test_it_is_cancelled(panda: to.Robot, gripper: Gripper, verb: Any) -> None:
    arguments = task(panda, gripper)
    if verb is pick:
        del arguments["places"]
    cancel = Event()
    cancel.set()
    carried = verb(**arguments, cancel=cancel)
    assert carried.status is Status.CANCELLED and carried.counts == {}
    cancel.clear()

    def progress(stage: str, _: object) -> None:
        if stage == "optimise":
            cancel.set()

    carried = verb(**arguments, cancel=cancel, progress=progress)
    assert carried.status is Status.CANCELLED and carried.counts["forward_kinematics"] > 0


def test_placing_is_cancelled_too(panda: to.Robot, gripper: Gripper) -> None:
    scene = on_table(panda, BLOCK, STOOD)
    grasp = grasps_of(scene, "thing", gripper)[0]
    held = scene.attach("thing", gripper.tool, placement=grasp.placement.inverse())
    cancel = Event()
    cancel.set()
    carried = place(held, "thing", start="ready", places=Place(placement=FUNCTIONS), cancel=cancel)
    assert carried.status is Status.CANCELLED


def test_progress_names_the_stages(panda: to.Robot, gripper: Gripper) -> None:
    arguments = task(panda, gripper)
    del arguments["places"]
    stages: list[str] = []
    assert pick(**arguments, progress=lambda stage, _: stages.append(stage)).verified
    assert stages[0] == "inverse kinematics"
    assert {"optimise", "retime", "verify"} <= set(stages)


def test_a_budget_that_improves_is_for_plan(panda: to.Robot, gripper: Gripper) -> None:
    with pytest.raises(ProblemError, match="cannot improve"):
        pick_and_place(**task(panda, gripper), budget=Budget(seconds=1.0, improve=True))

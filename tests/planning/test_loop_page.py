"""docs/planning-in-a-loop.md, block by block: an arm in MuJoCo, a camera, planning that takes its time."""

import sys
import time
import types
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.files.export.stand_ins import Clock, MujocoArm
from tests.pages import Page
from trajopt.planning import replan
from trajopt.values.arrays import Floats

THINKING = 0.06
"""How long planning takes here, in the arm's time [s]."""
ABOVE = np.array((0.0, 0.0, 0.25))
HERE, THERE = np.array((0.4, 0.35, 0.06)), np.array((0.4, 0.5, 0.06))


class DrivenArm(MujocoArm):
    """An arm whose driver evaluates a motion a thousand times a second."""

    def __init__(self, problem: to.Problem) -> None:
        super().__init__(problem, problem.reduced.start_positions)
        self.motions: list[to.Trajectory] = []
        self.sent: list[Floats] = []

    def drive(self, motion: to.Trajectory, begun: float) -> None:
        self.motions.append(motion)
        self.begun = begun

    def step(self) -> None:
        if self.motions:
            since, motion = self.data.time - self.begun, self.motions[-1]
            moving = since < motion.duration  # after the end: the end
            row = np.stack([motion(since, order) * (moving or order == 0) for order in range(3)])
            self.command(row[0], row[1], row[2])
            self.sent.append(row)
        super().step()


@dataclass
class Camera:
    """Sees a cup that is pushed to another place, and what else is there."""

    arm: DrivenArm | None = None
    blocked_after: float = np.inf

    def now(self) -> float:
        return 0.0 if self.arm is None else self.arm.data.time

    def cup(self) -> to.Placement:
        return to.placement(HERE + min(self.now() / 0.8, 1.0) * (THERE - HERE))

    def scene(self, scene: to.Scene) -> to.Scene:
        if self.now() < self.blocked_after:
            return scene
        return scene.add("wall", to.Box(0.9, 0.02, 1.0), to.placement((0.6, 0.3, 0.5)))


Loop = Callable[..., tuple[Page, DrivenArm]]


@pytest.fixture
def loop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Loop:
    """Run the page with a camera and a planner."""
    try:
        to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))

    def run(camera: Camera, budget: to.Budget | None = None) -> tuple[Page, DrivenArm]:
        page = Page("planning-in-a-loop.md", tmp_path)
        page.run("The problem", "One cycle")
        asked, scene = page.names["asked"], page.names["scene"]
        assert callable(asked)
        arm = DrivenArm(asked(camera.cup(), scene))
        camera.arm = arm
        clock = Clock(arm)

        def takes_its_time(
            problem: to.Problem, running: to.Trajectory, time: float, *, seconds: float
        ) -> to.Result:
            """Plan within work, not within seconds, so that the test is the same on every machine."""
            del seconds
            clock.sleep(THINKING)
            return replan(problem, running, time, budget=budget or to.Budget(attempts=3))

        times = types.ModuleType("time")
        times.__dict__.update(vars(time), monotonic=clock.monotonic, sleep=clock.sleep)
        monkeypatch.setitem(sys.modules, "time", times)
        page.names.update(camera=camera, arm=arm, replan=takes_its_time)
        page.run("The loop")
        return page, arm

    return run


def going(page: Page) -> tuple[to.Problem, to.Trajectory]:
    driven = page.names["going"]
    problem, motion = getattr(driven, "problem"), getattr(driven, "motion")  # noqa: B009
    assert isinstance(problem, to.Problem) and isinstance(motion, to.Trajectory)
    return problem, motion


def settle(arm: DrivenArm) -> None:
    Clock(arm).sleep(0.5)


def smooth(arm: DrivenArm, problem: to.Problem) -> None:
    """What was sent holds the limits, and no millisecond changes it by more than they allow."""
    limits, sent = problem.limits, np.array(arm.sent)
    for order, most in ((1, limits.velocity), (2, limits.acceleration)):
        assert (np.abs(sent[:, order]) <= most * (1.0 + 1e-6)).all()
        steps = np.abs(np.diff(sent[:, order - 1], axis=0))
        assert (steps <= most * 1.001e-3 + 1e-9).all()
    assert (np.abs(np.diff(sent[:, 2], axis=0)) <= limits.jerk * 1.001e-3 + 1e-9).all()


def test_the_hand_follows_a_cup_that_is_pushed(loop: Loop, capsys: pytest.CaptureFixture[str]) -> None:
    page, arm = loop(Camera())
    assert capsys.readouterr().out.splitlines()[-1].startswith("verified")
    problem, motion = going(page)
    settle(arm)
    smooth(arm, problem)
    hand = problem.scene.placement_of("panda_hand_tcp", problem.reduced.all_positions(arm.positions()))
    assert hand.translation == pytest.approx(THERE + ABOVE, abs=2e-3)
    spliced = [each for each in arm.motions[1:] if not np.array_equal(each.times, arm.motions[0].times)]
    assert len(spliced) >= 5
    strayed = [np.abs(q - motion(t)).max() for t, q in arm.visited]
    assert max(strayed) < 1e-3


def test_without_a_plan_the_old_motion_continues(loop: Loop) -> None:
    page, arm = loop(Camera(), to.Budget(work=1))
    assert len(arm.motions) > 5 and len({id(each) for each in arm.motions}) == 1
    problem, _ = going(page)
    settle(arm)
    hand = problem.scene.placement_of("panda_hand_tcp", problem.reduced.all_positions(arm.positions()))
    assert hand.translation == pytest.approx(HERE + ABOVE, abs=2e-3)


def test_in_front_of_a_wall_that_was_not_there_it_stops(loop: Loop) -> None:
    page, arm = loop(Camera(blocked_after=0.1), to.Budget(work=1))
    problem, motion = going(page)
    assert motion.duration < arm.motions[0].duration
    settle(arm)
    smooth(arm, problem)
    assert motion.velocities is not None and not motion.velocities[-1].any()
    seen = to.examine(problem.reduced, motion.positions[-1])
    assert not seen.collisions


def test_every_section_with_blocks_is_run(tmp_path: Path) -> None:
    page = Page("planning-in-a-loop.md", tmp_path)
    assert page.with_blocks == ["The problem", "One cycle", "The loop"]

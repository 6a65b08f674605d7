"""The pages of driving, block by block, with a controller of its own time."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.pages import Page
from trajopt.driving import CommittedMotion, EventKind, Supervisor
from trajopt.values.arrays import Floats


class Controller:
    """A controller that holds positions, with the time of the simulation."""

    def __init__(self, robot: to.Robot) -> None:
        self.at, self.rate, self.clock = robot.positions("ready"), np.zeros(len(robot.joint_names)), 0.0

    def positions(self) -> Floats:
        return self.at

    def velocities(self) -> Floats:
        return self.rate

    def time(self) -> float:
        return self.clock

    def send(self, positions: Floats, velocities: Floats) -> None:
        self.at, self.rate = positions, velocities

    def brake(self) -> None:
        self.rate = np.zeros(len(self.rate))

    def error(self) -> str:
        return ""

    def reset(self) -> None:
        pass


def test_every_block(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    controller, page = Controller(panda), Page("execution.md", tmp_path)
    servo, drivers = Page("servo.md", tmp_path), Page("drivers.md", tmp_path)
    servo.names = drivers.names = page.names

    def wait(seconds: float) -> None:
        """Let time pass; the driver's loop ticks every 4 ms, and is asked for states in between as well."""
        for _ in range(round(seconds / 0.001)):
            controller.clock = round(controller.clock + 0.001, 9)
            if round(1e3 * controller.clock) % 4 == 0:
                page.names["driver"].tick()

    page.names.update(controller=controller, wait=wait)
    page.run("A supervised robot")
    assert "reached" in capsys.readouterr().out
    page.run("A changing world")
    kinds = [event.kind for event in page.names["supervisor"].events]
    assert EventKind.REPLANNED in kinds and kinds[-1] is EventKind.REACHED
    page.run("Several goals")
    kinds = [event.kind for event in page.names["supervisor"].events]
    assert kinds in (
        [EventKind.STARTED, kind, EventKind.REACHED] for kind in (EventKind.PASSED, EventKind.REACHED)
    )
    page.run("Moving goals")
    kinds = [event.kind for event in page.names["supervisor"].events]
    assert EventKind.REPLANNED in kinds and kinds[-1] is EventKind.REACHED
    servo.run("Servo")
    assert "no command for 0.1" in capsys.readouterr().out
    servo.run("Gamepads and streams")
    capsys.readouterr()
    servo.run("A learned policy")
    assert "the first of the actions" in capsys.readouterr().out
    drivers.run("A driver for your robot")
    said = capsys.readouterr().out
    assert "FAIL" not in said and said.count("ok ") >= 16
    driver, problem = page.names["driver"], page.names["problem"]
    controller.at, driver.committed = (
        problem.start_positions,
        CommittedMotion(panda.joint_names, problem.start_positions),
    )
    supervisor = Supervisor(driver, problem)
    supervisor.go(problem)
    while supervisor.busy:
        supervisor.cycle()
        wait(0.019)
    assert [event.kind for event in supervisor.events] == [EventKind.STARTED, EventKind.REACHED]
    page.run("Rehearsal")

"""Driving the simulated robot of a session."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from trajopt.driving import SimulatedExecutor, Supervisor
from trajopt.driving.soonest_stop import StopTaken
from trajopt.problem.problem import Problem
from trajopt.server.move_group.driving import MotionDriver, mishaps
from trajopt.server.move_group.outcome import Execution
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.server.operations.planning import ABOUT, at_start, problem_in
from trajopt.values.arrays import Floats, Value
from trajopt.values.documents.document import Node
from trajopt.values.errors import ProblemError

STOPPING = 5.0


class SupervisedRun:
    """The simulated robot of a session, on its way to a goal."""

    def __init__(self, state: SessionState, problem: Problem, watch: Watch, speed: float) -> None:
        self._state, self._watch, self._speed = at_start(state, problem), watch, speed
        self._arm = SimulatedExecutor(problem.scene, problem.start_positions)
        self._supervisor = Supervisor(self._arm, problem)
        self._supervisor.see(problem.scene, 0.0)
        self._supervisor.go(problem)
        self._events, self._last = 0, 0.0

    def run(self, longest: float) -> Answer:
        """Drive until done, or stop after a simulated time [s]."""
        begin = time.monotonic()
        while self._going(longest):
            scene = self._watch.changed()
            if scene is not None:
                self._supervisor.see(scene)
            self._supervisor.cycle()
            self._arm.advance(CYCLE)
            self._tell()
            if self._speed:
                time.sleep(max(begin + self._arm.now() / self._speed - time.monotonic(), 0.0))
        stopped = self._watch.cancel.is_set() or (self._supervisor.moving and not self._arm.fault())
        if stopped:
            self._stop()
        return self._answer(stopped=stopped)

    def _going(self, longest: float) -> bool:
        watch, supervisor = self._watch, self._supervisor
        waiting = supervisor.blocked and not watch.heard
        return (
            supervisor.busy
            and not waiting
            and self._arm.now() < longest
            and not watch.cancel.is_set()
            and not self._arm.fault()
        )

    def _stop(self) -> None:
        self._supervisor.stop()
        until = self._arm.now() + STOPPING
        while self._supervisor.moving and self._arm.now() < until:
            self._supervisor.cycle()
            self._arm.advance(CYCLE)

    def _places(self) -> Floats:
        robot = self._state.scene.robot
        where = dict(zip(self._arm.joint_names, self._arm.truth().positions.tolist(), strict=True))
        return robot.positions({**self._state.named_positions, **where})

    def _tell(self) -> None:
        events, now = self._supervisor.events[self._events :], self._arm.now()
        if not events and now - self._last < TELLING:
            return
        self._events, self._last = len(self._supervisor.events), now
        places = self._places()
        names = self._state.scene.robot.joint_names
        self._watch.tell(
            {
                "time": now,
                "positions": dict(zip(names, places.tolist(), strict=True)),
                "events": [each.as_dict() for each in events],
            },
            places.tolist(),
        )

    def _answer(self, *, stopped: bool) -> Answer:
        supervisor, places = self._supervisor, self._places()
        events = supervisor.events
        names = self._state.scene.robot.joint_names
        return Answer(
            {
                "reached": not stopped and not supervisor.busy and not self._arm.fault(),
                "stopped": stopped,
                "duration": self._arm.now(),
                "fault": self._arm.fault(),
                "contacts": [str(each) for each in self._arm.contacts if each.allowance is None],
                "positions": dict(zip(names, places.tolist(), strict=True)),
                "events": [each.as_dict() for each in events],
            },
            replace(self._state, positions=places),
        )


def execute(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Plan to a goal and drive the simulated robot there, with changes of the session's scene on the way.

    `speed` is the rate of simulated time: 1 for real time, 0 for as fast as possible. Cancellation stops the
    robot, and so does the end of `longest`, a simulated time [s].
    """
    arguments.only((*ABOUT, "speed", "longest"))
    problem, _ = problem_in(state, arguments)
    speed, longest = arguments["speed"].number(1.0), arguments["longest"].number(60.0)
    if speed < 0.0 or longest <= 0.0:
        raise ProblemError("execute: speed must not be negative, and longest must be positive")
    return SupervisedRun(state, problem, watch, speed).run(longest)


TELLING = 0.1
"""Period of position updates, short enough for a smooth view [s]."""
CYCLE = 0.02
"""Period of the supervisor, as in its options [s]."""


@dataclass(frozen=True, eq=False)
class DriveOutcome(Value):
    """Outcome of driving a robot; `reason` is empty if it was driven."""

    positions: Floats
    reason: str = ""
    remark: str = ""
    stop: StopTaken | None = None


def drive_along(
    execution: Execution,
    positions: Floats,
    watch: Watch,
    look: Callable[[SimulatedExecutor, MotionDriver, float], None],
    *,
    speed: float = 1.0,
) -> DriveOutcome:
    """Drive the simulated robot along a trajectory; cancellation stops it by a proven stop.

    Args:
        look: Called at the start and periodically, with the elapsed time [s].
        speed: As in `execute`.
    """
    arm = SimulatedExecutor(execution.reduced.scene, positions)
    drive = MotionDriver(execution.reduced.scene.robot, arm, positions, arm.advance)
    refused = drive.start(execution.reduced, execution.trajectory)
    if refused:
        return DriveOutcome(positions, refused)
    begun, last, start = time.monotonic(), -TELLING, arm.now()
    while drive.moving and not watch.cancel.is_set():
        now = arm.now() - start
        if now - last >= TELLING:
            last = now
            look(arm, drive, now)
        arm.advance(CYCLE)
        if speed:
            time.sleep(max(begun + (arm.now() - start) / speed - time.monotonic(), 0.0))
    stop = drive.stop() if watch.cancel.is_set() else None
    remarks = [drive.wait(), *mishaps(arm)]
    return DriveOutcome(drive.positions, remark="; ".join(each for each in remarks if each), stop=stop)

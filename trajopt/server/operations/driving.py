"""Driving the simulated robot of a session."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from trajopt.driving import SimulatedExecutor
from trajopt.driving.rehearsal import LiveRun
from trajopt.driving.soonest_stop import StopTaken
from trajopt.server.move_group.driving import MotionDriver, mishaps_of
from trajopt.server.move_group.outcome import Execution
from trajopt.server.operation import Answer, SessionState, Watch
from trajopt.server.operations.planning import ABOUT, at_start, problem_in
from trajopt.values.arrays import Floats, Value
from trajopt.values.documents.document import Node
from trajopt.values.errors import ProblemError


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
    begun, run, told, last = at_start(state, problem), LiveRun(problem), 0, 0.0
    arm, supervisor, robot = run.arm, run.supervisor, begun.scene.robot

    def now() -> SessionState:
        driven = dict(zip(arm.joint_names, arm.truth().positions.tolist(), strict=True))
        return replace(begun, positions=robot.positions({**begun.named_positions, **driven}))

    def tell() -> None:
        nonlocal told, last
        events, time = [each.as_dict() for each in supervisor.events[told:]], arm.now()
        if events or time - last >= TELLING:
            told, last, here = len(supervisor.events), time, now()
            document = {"time": time, "positions": here.named_positions, "events": events}
            watch.tell(document, here.positions.tolist())

    stopped = run.drive(
        watch.cancel.is_set, watch.changed, tell, patient=watch.heard, longest=longest, speed=speed
    )
    end = now()
    return Answer(
        {
            "reached": not stopped and not supervisor.busy and not arm.fault(),
            "stopped": stopped,
            "duration": arm.now(),
            "fault": arm.fault(),
            "contacts": run.touched,
            "positions": end.named_positions,
            "events": [each.as_dict() for each in supervisor.events],
        },
        end,
    )


TELLING = 0.1
"""Period of position updates, short enough for a smooth view [s]."""
CYCLE = 0.02
"""Period in which a cancellation is noticed [s]."""


@dataclass(frozen=True, eq=False)
class DriveOutcome(Value):
    """Outcome of driving a robot; `reason` is empty if it was driven.

    Attributes:
        met: The contact ahead for which it was stopped when the scene changed; empty if there was none.
    """

    positions: Floats
    reason: str = ""
    remark: str = ""
    stop: StopTaken | None = None
    met: str = ""


def drive_along(
    execution: Execution,
    positions: Floats,
    watch: Watch,
    look: Callable[[SimulatedExecutor, MotionDriver, float], None],
    *,
    speed: float = 1.0,
) -> DriveOutcome:
    """Drive the simulated robot along a trajectory.

    Cancellation stops it by a proven stop, and so does a change of the session's scene if what is left of the
    motion is not clear in it.

    Args:
        look: Called at the start and periodically, with the elapsed time [s].
        speed: As in `execute`.
    """
    arm = SimulatedExecutor(execution.reduced.scene, positions)
    drive = MotionDriver(execution.reduced.scene.robot, arm, positions, arm.advance)
    refused = drive.start(execution.reduced, execution.trajectory)
    if refused:
        return DriveOutcome(positions, refused)
    begun, last, start, met, mishaps = time.monotonic(), -TELLING, arm.now(), "", list[str]()
    while drive.moving and not watch.cancel.is_set() and not met:
        now = arm.now() - start
        if (scene := watch.changed()) is not None:
            mishaps += mishaps_of(arm)
            arm.change(scene, begin=arm.now(), duration=max(execution.trajectory.duration - now, 0.0))
            met = drive.see(scene)
        if now - last >= TELLING:
            last = now
            look(arm, drive, now)
        arm.advance(CYCLE)
        if speed:
            time.sleep(max(begun + (arm.now() - start) / speed - time.monotonic(), 0.0))
    stop = drive.stop() if watch.cancel.is_set() or met else None
    remarks = dict.fromkeys((met, drive.wait(), *mishaps, *mishaps_of(arm)))
    remark = "; ".join(each for each in remarks if each)
    return DriveOutcome(drive.positions, remark=remark, stop=stop, met=met)

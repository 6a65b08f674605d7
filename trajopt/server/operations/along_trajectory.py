"""Driving the simulated robot along a given trajectory, to its end or a stop."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from trajopt.driving import SimulatedExecutor
from trajopt.driving.soonest_stop import StopTaken
from trajopt.server.move_group.driving import Drive
from trajopt.server.move_group.execution import Execution
from trajopt.server.move_group.in_process import on_the_way
from trajopt.server.watch import Watch
from trajopt.values.arrays import Floats, Value

TELLING = 0.1
"""Period of position updates, short enough for a smooth view [s]."""
CYCLE = 0.02
"""Period of the supervisor, as in its options [s]."""


@dataclass(frozen=True, eq=False)
class Driven(Value):
    """Outcome of driving a robot.

    Attributes:
        positions: Final positions of all its joints [rad | m].
        reason: The reason why it was not driven; empty if it was.
        remark: Faults during the motion; empty without any.
        stop: The stop that ended the motion early, or None.
    """

    positions: Floats
    reason: str = ""
    remark: str = ""
    stop: StopTaken | None = None


def drive_along(
    execution: Execution,
    positions: Floats,
    watch: Watch,
    look: Callable[[SimulatedExecutor, Drive, float], None],
    *,
    speed: float = 1.0,
) -> Driven:
    """Drive the simulated robot along a trajectory; cancellation stops it by a proven stop.

    Args:
        execution: The trajectory, and its scene.
        positions: Of all joints [rad | m].
        watch: Of the request.
        look: Called at the start and periodically, with the elapsed time [s].
        speed: Speed of simulated time: 1 for real time, 0 for as fast as possible.
    """
    arm = SimulatedExecutor(execution.reduced.scene, positions)
    drive = Drive(execution.reduced.scene.robot, arm, positions, arm.advance)
    refused = drive.start(execution.reduced, execution.trajectory)
    if refused:
        return Driven(positions, refused)
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
    remarks = [drive.wait(), *on_the_way(arm)]
    return Driven(drive.positions, remark="; ".join(each for each in remarks if each), stop=stop)

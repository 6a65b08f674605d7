"""Driving the simulated robot along a trajectory that somebody has: to its end, or until it is stopped."""

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
"""Who watches a robot sees it move smoothly enough at so many seconds between two places [s]."""
CYCLE = 0.02
"""Time from one look at the robot to the next, and of its supervisor: as its options have it [s]."""


@dataclass(frozen=True, eq=False)
class Driven(Value):
    """How driving a robot ended.

    Attributes:
        positions: Where all its joints are now [rad | m].
        reason: Why it was not driven; empty if it was.
        remark: What went wrong on the way; empty if nothing did.
        stop: The stop that ended the motion before its end; None if none did.
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
    """Drive the simulated robot along a trajectory; a request that is cancelled stops it when that is proven.

    Args:
        execution: The trajectory, and the scene in which it is driven.
        positions: Where all joints stand [rad | m].
        watch: Of the request.
        look: Called at the begin and from time to time, with the time since then [s].
        speed: Of time: 1 as in the world, 0 as fast as the machine goes.
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

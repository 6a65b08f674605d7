"""Driving a robot along proven motions, watched in every cycle, and able to stop at all times."""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING

from trajopt.driving.arms import FrankaController as FrankaController
from trajopt.driving.arms import UrController as UrController
from trajopt.driving.committed_motion import CommittedMotion as CommittedMotion
from trajopt.driving.conformance import Rule as Rule
from trajopt.driving.conformance import conformance as conformance
from trajopt.driving.events import Event as Event
from trajopt.driving.events import EventKind as EventKind
from trajopt.driving.executor import Executor as Executor
from trajopt.driving.executor import GripperDriver as GripperDriver
from trajopt.driving.executor import GripperState as GripperState
from trajopt.driving.executor import IdealExecutor as IdealExecutor
from trajopt.driving.executor import RobotState as RobotState
from trajopt.driving.guard import ActionOutcome as ActionOutcome
from trajopt.driving.guard import Decision as Decision
from trajopt.driving.guard import Guard as Guard
from trajopt.driving.guard import GuardOptions as GuardOptions
from trajopt.driving.lerobot import GuardedArm as GuardedArm
from trajopt.driving.lerobot import LeRobotController as LeRobotController
from trajopt.driving.lerobot import MotorJoint as MotorJoint
from trajopt.driving.options import SupervisorOptions as SupervisorOptions
from trajopt.driving.recording import Logbook as Logbook
from trajopt.driving.recording import RecordedDecision as RecordedDecision
from trajopt.driving.recording import RecordedMoment as RecordedMoment
from trajopt.driving.recording import RecordedMotion as RecordedMotion
from trajopt.driving.recording import Recording as Recording
from trajopt.driving.recording import Sighting as Sighting
from trajopt.driving.recording import read_recording as read_recording
from trajopt.driving.recording import write_recording as write_recording
from trajopt.driving.servo import Servo as Servo
from trajopt.driving.servo_command import Axis as Axis
from trajopt.driving.servo_command import Command as Command
from trajopt.driving.servo_command import JointVelocities as JointVelocities
from trajopt.driving.servo_command import Pose as Pose
from trajopt.driving.servo_command import ServoOptions as ServoOptions
from trajopt.driving.servo_command import Twist as Twist
from trajopt.driving.servo_input import Gamepad as Gamepad
from trajopt.driving.servo_input import Order as Order
from trajopt.driving.servo_input import Player as Player
from trajopt.driving.servo_input import Recorder as Recorder
from trajopt.driving.servo_input import ServoInput as ServoInput
from trajopt.driving.servo_input import Stream as Stream
from trajopt.driving.servo_input import TimedOrder as TimedOrder
from trajopt.driving.servo_input import guide as guide
from trajopt.driving.servo_input import read_stream as read_stream
from trajopt.driving.soonest_stop import StopTaken as StopTaken
from trajopt.driving.streaming import PositionController as PositionController
from trajopt.driving.streaming import StreamingExecutor as StreamingExecutor
from trajopt.driving.supervisor import Supervisor as Supervisor

if _TYPE_CHECKING:
    from trajopt.driving.rehearsal import RunReport as RunReport
    from trajopt.driving.rehearsal import TaskReport as TaskReport
    from trajopt.driving.rehearsal import run as run
    from trajopt.driving.run_log import write_mcap as write_mcap
    from trajopt.driving.run_log import write_rerun as write_rerun
    from trajopt.driving.simulated import Fault as Fault
    from trajopt.driving.simulated import FaultKind as FaultKind
    from trajopt.driving.simulated import Sensors as Sensors
    from trajopt.driving.simulated import SimulatedExecutor as SimulatedExecutor
    from trajopt.driving.simulated import SimulatedGripper as SimulatedGripper
    from trajopt.driving.surprises import Surprise as Surprise
    from trajopt.driving.surprises import Surprises as Surprises
    from trajopt.driving.surprises import random_surprise as random_surprise
    from trajopt.driving.surprises import read_surprises as read_surprises
    from trajopt.driving.surprises import undisturbed as undisturbed

_LATER = {
    "rehearsal": "RunReport TaskReport run",
    "run_log": "write_mcap write_rerun",
    "simulated": "Fault FaultKind Sensors SimulatedExecutor SimulatedGripper",
    "surprises": "Surprise Surprises random_surprise read_surprises undisturbed",
}
"""Module -> the names that it defines."""
_HOME = {name: module for module, names in _LATER.items() for name in names.split()}


def _imported(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'trajopt.driving' has no attribute {name!r}")
    found: object = getattr(_import_module(f"trajopt.driving.{_HOME[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})


if not _TYPE_CHECKING:  # type checkers know the names from the imports above
    __getattr__ = _imported

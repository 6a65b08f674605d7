"""Execution: a robot driven along proven motions, watched, and always able to stop."""

from trajopt.execution.committed_motion import CommittedMotion as CommittedMotion
from trajopt.execution.conformance import Rule as Rule
from trajopt.execution.conformance import conformance as conformance
from trajopt.execution.events import Event as Event
from trajopt.execution.events import Kind as Kind
from trajopt.execution.executor import Executor as Executor
from trajopt.execution.executor import RobotState as RobotState
from trajopt.execution.faults import Fault as Fault
from trajopt.execution.faults import FaultKind as FaultKind
from trajopt.execution.ideal import IdealExecutor as IdealExecutor
from trajopt.execution.options import SupervisorOptions as SupervisorOptions
from trajopt.execution.random_surprise import random_surprise as random_surprise
from trajopt.execution.run import Run as Run
from trajopt.execution.run import run as run
from trajopt.execution.simulated import Sensors as Sensors
from trajopt.execution.simulated import SimulatedExecutor as SimulatedExecutor
from trajopt.execution.soonest_stop import StopTaken as StopTaken
from trajopt.execution.supervisor import Supervisor as Supervisor
from trajopt.execution.surprises import Surprise as Surprise
from trajopt.execution.surprises import Surprises as Surprises
from trajopt.execution.surprises import read_surprises as read_surprises

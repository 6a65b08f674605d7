"""Stand-ins for what docs/your-robot.md talks to: a Franka, and an arm in MuJoCo with its clock."""

import types
from dataclasses import dataclass, field

import mujoco
import numpy as np

import trajopt as to
from trajopt.simulation import build_spec
from trajopt.values.arrays import Floats

STEP = 0.001
"""Cycle of the drives and of the physics [s]."""


class Clock:
    """The time that an arm lives in: sleeping moves the arm on."""

    def __init__(self, arm: "MujocoArm") -> None:
        self.arm = arm

    def monotonic(self) -> float:
        return self.arm.data.time

    def sleep(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP)):
            self.arm.step()


class MujocoArm:
    """An arm in MuJoCo whose drives extrapolate the last command until the next one comes."""

    def __init__(self, problem: to.Problem, start: Floats) -> None:
        spec = build_spec(problem.reduced)
        spec.option.timestep = STEP
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        names = problem.reduced.joint_names
        self.places = [self.model.joint(name).qposadr[0] for name in names]
        self.speeds = [self.model.joint(name).dofadr[0] for name in names]
        self.motors = [self.model.actuator(name).id for name in names]
        self.data.qpos[self.places] = start
        self.given = (0.0, start, 0.0 * start, 0.0 * start)
        self.visited: list[tuple[float, Floats]] = []

    def positions(self) -> Floats:
        return self.data.qpos[self.places].copy()

    def command(self, position: Floats, velocity: Floats, acceleration: Floats) -> None:
        self.given = (self.data.time, position, velocity, acceleration)

    def step(self) -> None:
        since, (_, q, v, a) = self.data.time - self.given[0], self.given
        mujoco.mj_forward(self.model, self.data)
        off = q + v * since + a * since**2 / 2 - self.data.qpos[self.places]
        slow = v + a * since - self.data.qvel[self.speeds]
        wanted, torque = np.zeros((2, self.model.nv))
        wanted[self.speeds] = a + 2 * 50.0 * slow + 50.0**2 * off
        mujoco.mj_mulM(self.model, self.data, torque, wanted)
        self.data.ctrl[self.motors] = (torque + self.data.qfrc_bias)[self.speeds]
        mujoco.mj_step(self.model, self.data)
        self.visited.append((self.data.time, self.positions()))


@dataclass
class Period:
    """A time that has passed."""

    seconds: float

    def to_sec(self) -> float:
        return self.seconds


@dataclass
class FrankaState:
    """Where the arm was last told to be."""

    q_d: list[float]


class JointPositions:
    """A command."""

    def __init__(self, q: list[float]) -> None:
        assert len(q) == 7
        self.q, self.motion_finished = q, False


@dataclass
class Franka:
    """An arm that goes where it is told, and refuses jumps; every hundredth packet is lost."""

    joints: list[float]
    time: float = 0.0
    cycles: int = 0
    finished: bool = False
    visited: list[tuple[float, list[float]]] = field(default_factory=list)

    def read_once(self) -> FrankaState:
        return FrankaState(list(self.joints))

    def start_joint_position_control(self, mode: str) -> "Franka":
        assert mode == "JointImpedance"
        return self

    def readOnce(self) -> tuple[FrankaState, Period]:
        period = 0.0 if self.cycles == 0 else 0.002 if self.cycles % 100 == 0 else 0.001
        self.cycles, self.time = self.cycles + 1, self.time + period
        return self.read_once(), Period(period)

    def writeOnce(self, command: JointPositions) -> None:
        assert not self.finished
        # 2.175 rad/s is the slowest joint's limit, over the two milliseconds of a lost packet.
        assert np.abs(np.array(command.q) - self.joints).max() <= 2.175 * 0.002 + 1e-9
        self.joints, self.finished = command.q, command.motion_finished
        self.visited.append((self.time, command.q))


def pylibfranka(robot: Franka) -> types.ModuleType:
    """Return a module that is to the page what pylibfranka is to an arm."""
    module = types.ModuleType("pylibfranka")
    module.__dict__.update(
        Robot=lambda address: robot,
        JointPositions=JointPositions,
        ControllerMode=types.SimpleNamespace(JointImpedance="JointImpedance"),
    )
    return module

"""A robot of LeRobot in MuJoCo; LeRobot looks for the class in a module of its name."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from threading import Lock
from typing import Any

import numpy as np
from lerobot.robots import Robot, RobotConfig

import trajopt as to
from trajopt.driving import MotorJoint
from trajopt.scene.reducing import whole_robot
from trajopt.simulation import SimulationOptions
from trajopt.simulation.execution import ComputedTorque

STEP = 2e-3
"""Time step of the simulation [s]."""
BANDWIDTH = 200.0
"""Natural frequency of the motors [rad/s]."""
LAG = 2.0 / BANDWIDTH - 0.01
"""Their delay: that of a critically damped system, less half of the period of commands [s]."""


@RobotConfig.register_subclass("simulated_arm")
@dataclass(kw_only=True)
class SimulatedArmConfig(RobotConfig):
    motors: dict[str, MotorJoint] = field(default_factory=dict[str, MotorJoint])


class SimulatedArm(Robot):
    """Position servos in MuJoCo; the simulation follows the clock of the machine when it is used."""

    config_class, name = SimulatedArmConfig, "simulated_arm"
    scene: to.Scene
    start: Mapping[str, float]

    def __init__(self, config: SimulatedArmConfig) -> None:
        super().__init__(config)
        self.motors, self._lock, self.is_open = config.motors, Lock(), False
        self.touched = set[tuple[str, str]]()

    @property
    def observation_features(self) -> dict[str, Any]:
        return dict.fromkeys(self.motors, float)

    @property
    def action_features(self) -> dict[str, Any]:
        return dict.fromkeys(self.motors, float)

    @property
    def is_connected(self) -> bool:
        return self.is_open

    @property
    def is_calibrated(self) -> bool:
        return True

    def calibrate(self) -> None:
        pass

    def configure(self) -> None:
        pass

    def connect(self, calibrate: bool = True) -> None:
        from trajopt.simulation.plant import Plant

        robot = self.scene.robot
        joints = tuple(motor.joint for motor in self.motors.values())
        full = np.array([self.start.get(name, 0.0) for name in robot.joint_names])
        whole = whole_robot(self.scene, joints, robot.followed(full))
        self.plant, self.torques = Plant(whole, STEP), ComputedTorque(whole, SimulationOptions(dt=STEP))
        begin = np.array([self.start.get(name, 0.0) for name in joints])
        self.plant.reset(begin, np.zeros(len(begin)))
        self.reference = np.stack((begin, 0.0 * begin, 0.0 * begin))
        self.goal, self.begun, self.steps = begin, time.monotonic(), 0
        self.is_open = True

    def disconnect(self) -> None:
        self.is_open = False

    def get_observation(self) -> dict[str, Any]:
        with self._lock:
            self._catch_up()
            rows = zip(self.motors.items(), self.torques.group(self.plant.positions), strict=True)
            return {name: float((at - motor.offset) / motor.scale) for (name, motor), at in rows}

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        with self._lock:
            self._catch_up()
            self.goal = np.array(
                [motor.scale * action[name] + motor.offset for name, motor in self.motors.items()]
            )
        return action

    def _catch_up(self) -> None:
        while self.steps * STEP < time.monotonic() - self.begun:
            where, speed, _ = self.reference
            gain = BANDWIDTH**2 * (self.goal - where) - 2.0 * BANDWIDTH * speed
            speed = speed + STEP * gain
            self.reference = np.stack((where + STEP * speed, speed, gain))
            torques = self.torques(self.reference, self.plant.positions, self.plant.velocities)
            self.touched |= set(self.plant.step(torques))
            self.steps += 1

"""A LeRobot robot that drives another one behind trajopt's guard: `--robot.type=trajopt_guarded`."""

from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

import draccus
from lerobot.robots import Robot, RobotConfig, make_robot_from_config
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError

import trajopt as to
from trajopt.driving import Guard, GuardedArm, GuardOptions, LeRobotController, MotorJoint, StreamingExecutor
from trajopt.files.moveit import read_scene

NOT_CONNECTED = "the guarded robot is not connected; call connect"


@RobotConfig.register_subclass("trajopt_guarded")
@dataclass(kw_only=True)
class GuardedRobotConfig(RobotConfig):
    """The guarded robot, and its model.

    Attributes:
        robot: Configuration of the robot that is guarded, of any type. It is a dictionary, because LeRobot's
            commands list the options of all types, which would not end.
        motors: Feature -> its joint.
        description: An installed robot of trajopt, or its URDF, xacro or MJCF file.
        group: Group of the joints of the motors.
        tolerance: Largest tracking error of a joint [rad].
        srdf: MoveIt's semantic description, for a file.
        package_dirs: Folders with the packages of its meshes, for a file.
        scene: Objects around the robot: MoveIt's planning scene, YAML; none if empty.
        fps: Actions per second [Hz].
        period: Time between commands to the motors [s].
        lead: Time for a decision [s]; a decision that takes longer stops the robot.
        lag: Time by which the motors are behind their commands, in addition to a period [s].
    """

    robot: dict[str, Any]
    motors: dict[str, MotorJoint]
    description: str
    group: str
    tolerance: float
    srdf: str | None = None
    package_dirs: list[str] = field(default_factory=list[str])
    scene: str = ""
    fps: float = 30.0
    period: float = 0.02
    lead: float = 0.02
    lag: float = 0.0


class GuardedRobot(Robot):
    """A robot whose actions are driven only as far as they are proven.

    Attributes:
        config: Its configuration.
        robot: The robot that is guarded.
        arm: The arm while it is connected; `arm.guard.see` reports the world.
    """

    config_class = GuardedRobotConfig
    name = "trajopt_guarded"

    def __init__(self, config: GuardedRobotConfig) -> None:
        """Read the model; the robot is not connected yet."""
        super().__init__(config)
        inner = draccus.decode(RobotConfig, config.robot)
        self.config, self.robot = config, make_robot_from_config(inner)
        model = to.load(config.description, srdf=config.srdf, package_dirs=config.package_dirs)
        self._scene = read_scene(config.scene, model).scene if config.scene else to.Scene(model)
        self._open, self.arm = ExitStack(), None
        self.arm: GuardedArm | None

    @property
    def cameras(self) -> dict[str, Any]:
        """Cameras of the robot."""
        return getattr(self.robot, "cameras", {})

    @property
    def observation_features(self) -> dict[str, Any]:
        """Features of the robot."""
        return self.robot.observation_features

    @property
    def action_features(self) -> dict[str, Any]:
        """Features of the robot."""
        return self.robot.action_features

    @property
    def is_connected(self) -> bool:
        """Whether it is connected and guarded."""
        return self.arm is not None and self.robot.is_connected

    def connect(self, calibrate: bool = True) -> None:
        """Connect, and drive the robot in a thread from now on; it must be at rest."""
        if self.arm is not None:
            raise DeviceAlreadyConnectedError(f"{self.name} is connected")
        config = self.config
        with ExitStack() as opened:
            self.robot.connect(calibrate)
            opened.callback(self.robot.disconnect)
            controller = LeRobotController(self.robot, config.motors)
            executor = StreamingExecutor(
                controller,
                controller.joint_names,
                tolerance=config.tolerance,
                period=config.period,
                lag=config.lag,
            )
            opened.enter_context(executor)
            guard = Guard(self._scene, config.group, executor, options=GuardOptions(lead=config.lead))
            self.arm = GuardedArm(controller, guard, fps=config.fps)
            self._open = opened.pop_all()

    @property
    def is_calibrated(self) -> bool:
        """Whether the robot is calibrated."""
        return self.robot.is_calibrated

    def calibrate(self) -> None:
        """Calibrate the robot, before it is connected."""
        self.robot.calibrate()

    def configure(self) -> None:
        """Do nothing: the robot configures itself when it connects."""

    def get_observation(self) -> dict[str, Any]:
        """Return the last observation; one is made in each period."""
        return self._connected.observe()

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Drive to an action as far as it is proven; return the action that is sent."""
        return self._connected.send(action)

    def disconnect(self) -> None:
        """Stop the robot, and disconnect it."""
        if self.arm is None:
            raise DeviceNotConnectedError(NOT_CONNECTED)
        self.arm = None
        self._open.close()

    @property
    def _connected(self) -> GuardedArm:
        if self.arm is None:
            raise DeviceNotConnectedError(NOT_CONNECTED)
        return self.arm

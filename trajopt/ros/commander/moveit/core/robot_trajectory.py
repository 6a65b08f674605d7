"""Stand-in for `moveit.core.robot_trajectory`: a motion of a group."""

from collections.abc import Iterator

from trajopt.files.messages import RobotTrajectory as RobotTrajectoryMessage
from trajopt.ros.commander.moveit.core.robot_model import InPart, RobotModel
from trajopt.ros.commander.moveit.core.robot_state import RobotState


class RobotTrajectory(InPart):
    """A motion."""

    def __init__(self, robot_model: RobotModel) -> None:
        self.robot_model, self.joint_model_group_name = robot_model, ""
        self._start, self._message = RobotState(robot_model), RobotTrajectoryMessage()

    @property
    def duration(self) -> float:
        points = self._message.joint_trajectory.points
        return points[-1].time_from_start.to_sec() if points else 0.0

    @property
    def average_segment_duration(self) -> float:
        """Mean time between successive points [s]."""
        return self.duration / max(len(self) - 1, 1)

    def get_waypoint_durations(self) -> list[float]:
        """Return the time of each point since the previous one, starting with 0 [s]."""
        times = [point.time_from_start.to_sec() for point in self._message.joint_trajectory.points]
        return [after - before for before, after in zip([0.0, *times], times, strict=False)]

    def get_robot_trajectory_msg(self, joint_filter: object = None) -> RobotTrajectoryMessage:
        """Return the motion as a message."""
        return self._message

    def set_robot_trajectory_msg(self, robot_state: RobotState, msg: RobotTrajectoryMessage) -> None:
        """Read a motion from a message; missing joints are taken from a state."""
        self._start, self._message = robot_state.__copy__(), msg

    def __len__(self) -> int:
        return len(self._message.joint_trajectory.points)

    def __getitem__(self, index: int) -> RobotState:
        motion, state = self._message.joint_trajectory, self._start.__copy__()
        state.joint_positions = dict(zip(motion.joint_names, motion.points[index].positions, strict=True))
        return state

    def __iter__(self) -> Iterator[RobotState]:
        return (self[index] for index in range(len(self)))

"""Stand-in for `moveit.core.kinematic_constraints`: constraints messages."""

from collections.abc import Sequence

from trajopt.files import messages as msg
from trajopt.ros.commander.moveit.core.robot_model import JointModelGroup
from trajopt.ros.commander.moveit.core.robot_state import RobotState
from trajopt.server.move_group.outcome import MoveItCommanderException


def construct_joint_constraint(
    robot_state: RobotState, joint_model_group: JointModelGroup, tolerance: float = 0.01
) -> msg.Constraints:
    names = joint_model_group.active_joint_model_names
    values = robot_state.joint_positions
    held = [msg.JointConstraint(name, values[name], tolerance, tolerance, 1.0) for name in names]
    return msg.Constraints(joint_constraints=held)


def construct_link_constraint(
    link_name: str,
    source_frame: str,
    cartesian_position: Sequence[float] | None = None,
    cartesian_position_tolerance: float | None = None,
    orientation: Sequence[float] | None = None,
    orientation_tolerance: float | None = None,
) -> msg.Constraints:
    """Construct constraints on the pose of a link.

    Args:
        cartesian_position: x, y, z [m].
        cartesian_position_tolerance: Radius of the sphere around the position [m].
        orientation: x, y, z, w.
        orientation_tolerance: About each axis [rad].
    """
    if cartesian_position is None and orientation is None:
        raise MoveItCommanderException("construct_link_constraint: give a position, an orientation or both")
    made, header = msg.Constraints(), msg.Header(frame_id=source_frame)
    if cartesian_position is not None:
        radius = _stated("cartesian_position_tolerance", cartesian_position_tolerance)
        region = msg.BoundingVolume(
            [msg.SolidPrimitive(msg.SolidPrimitive.SPHERE, [radius])],
            [msg.Pose(msg.Point(*cartesian_position))],
        )
        held = msg.PositionConstraint(header, link_name, constraint_region=region, weight=1.0)
        made.position_constraints.append(held)
    if orientation is not None:
        angle = _stated("orientation_tolerance", orientation_tolerance)
        turned = msg.Quaternion(*orientation)
        made.orientation_constraints.append(
            msg.OrientationConstraint(header, turned, link_name, angle, angle, angle, weight=1.0)
        )
    return made


def _stated(name: str, tolerance: float | None) -> float:
    if tolerance is None:
        raise MoveItCommanderException(f"construct_link_constraint: {name} is missing")
    return tolerance

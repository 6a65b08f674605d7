"""Unit of a joint's position: angle or length."""

from trajopt.model.robot import Robot


def joint_unit(robot: Robot, joint: str, *, order: int = 0) -> str:
    """Return the unit of a joint's position or a derivative of it.

    Args:
        robot: The robot.
        joint: Name of one of its movable joints.
        order: 0 position, 1 velocity, 2 acceleration, 3 jerk.
    """
    kind = str(robot.model.joints[robot.model.getJointId(joint)].shortname())
    unit = "m" if kind.startswith("JointModelP") else "rad"
    return unit + ("", "/s", "/s^2", "/s^3")[order]

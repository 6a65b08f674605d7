"""Where a robot stands of which nobody has said where."""

from trajopt.robot.robot import Robot
from trajopt.values.arrays import Floats


def initial_positions(robot: Robot) -> Floats:
    """Return positions of all joints, each group in its first named state.

    Args:
        robot: The robot.

    Returns:
        Positions, shape (number of joints,) [rad | m]; at their default for joints of no such group.
    """
    chosen: dict[str, float] = {}
    for group in robot.groups:
        name = next((state for owner, state in robot.states if owner == group), None)
        if name is not None:
            chosen = {**robot.state(name, group=group), **chosen}
    return robot.positions(chosen)

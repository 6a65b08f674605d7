"""Node: what a script has set and asked for that is neither robot nor scene."""

from collections.abc import Callable
from dataclasses import dataclass, field

from trajopt.server.move_group.outcome import MoveItCommanderException

OF_THE_ROBOT = ("robot_description", "robot_description_semantic")
"""Parameters that launch files set; the robot of the world is in their place."""


@dataclass
class Node:
    """A script's parameters, and what it does when it ends.

    Attributes:
        name: What the script calls itself.
        parameters: Values by name, without a leading slash.
        hooks: What is called when the script ends, the first first.
        shut_down: Whether the script was told to end.
    """

    name: str = "script"
    parameters: dict[str, object] = field(default_factory=dict[str, object])
    hooks: list[Callable[[], object]] = field(default_factory=list[Callable[[], object]])
    shut_down: bool = False

    def end(self) -> None:
        """Call what is to be called at the end, once."""
        self.shut_down = True
        while self.hooks:
            self.hooks.pop(0)()

    def has(self, name: str) -> bool:
        """Say whether there is a parameter of that name."""
        key = name.removeprefix("/")
        return key in self.parameters or key in OF_THE_ROBOT

    def parameter(self, name: str) -> object:
        """Return the value of a parameter.

        Raises:
            KeyError: If there is none of that name.
            MoveItCommanderException: If it is a text of the robot's files, which are not kept.
        """
        key = name.removeprefix("/")
        if key not in self.parameters and key in OF_THE_ROBOT:
            raise MoveItCommanderException(
                f"rospy.get_param({key!r}): the text of the robot's files is not kept; RobotCommander knows "
                "its groups, joints and links"
            )
        return self.parameters[key]

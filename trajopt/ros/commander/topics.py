"""Publisher: logs published messages; scene and object messages change the world."""

import logging
from typing import Any

from trajopt.files.messages import (
    AttachedCollisionObject,
    CollisionObject,
    DisplayTrajectory,
    PlanningScene,
    field_names,
    is_message,
)
from trajopt.ros.commander.planning_scene_interface import PlanningSceneInterface
from trajopt.ros.commander.world import world_or_current
from trajopt.server.move_group.outcome import MoveItCommanderException
from trajopt.values.errors import shown

_LOG = logging.getLogger("trajopt.ros.commander")


class Publisher:
    """Publishes messages of one type.

    `CollisionObject`, `AttachedCollisionObject` and `PlanningScene` change the world's scene, as a
    subscribed `move_group` node would. Other messages are logged.
    """

    def __init__(self, name: str, data_class: type, *_: object, **__: object) -> None:
        """Select a topic.

        Args:
            name: Name of the topic.
            data_class: Type of its messages; further arguments (`queue_size`, `latch`) are ignored.
        """
        self.name = name
        self.data_class = data_class
        self._world = world_or_current(None)

    def get_num_connections(self) -> int:
        """Return 1: the log."""
        return 1

    def unregister(self) -> None:
        """Do nothing; there is no ROS master."""

    def publish(self, *args: Any, **fields: Any) -> None:
        """Log a message, or apply it to the scene.

        Args:
            args: The message, or its fields in order.
            fields: Its fields by name.

        Raises:
            MoveItCommanderException: If the message has another type, or cannot be applied.
        """
        whole = len(args) == 1 and not fields and _is_message(args[0], self.data_class)
        alone = args[0] if whole else None
        kind = self.data_class.__name__
        if alone is not None and type(alone).__name__ != kind:
            raise MoveItCommanderException(
                f"topic {shown(self.name)} takes {kind}, not {type(alone).__name__}"
            )
        message = self.data_class(*args, **fields) if alone is None else alone
        scene = PlanningSceneInterface(world=self._world)
        match message:
            case CollisionObject():
                scene.add_object(message)
            case AttachedCollisionObject():
                scene.process_attached(message)
            case PlanningScene():
                scene.apply_planning_scene(message)
            case _:
                pass
        _LOG.info("%s: %s", self.name, _told(message))


def _is_message(value: object, kind: type) -> bool:
    """Return whether a value is a message; some messages have no fields."""
    return isinstance(value, kind) or bool(field_names(value))


def _told(message: Any) -> str:
    """Return the log text of a message."""
    if not isinstance(message, DisplayTrajectory) or not all(
        is_message(each, "joint_trajectory") for each in message.trajectory
    ):
        return shown(message)
    told: list[str] = []
    for each in message.trajectory:
        motion = each.joint_trajectory
        seconds = motion.points[-1].time_from_start.to_sec() if motion.points else 0.0
        told.append(f"{len(motion.points)} points of {len(motion.joint_names)} joints, {seconds:.2f} s")
    return f"DisplayTrajectory: {'; '.join(told) or 'no trajectory'}"

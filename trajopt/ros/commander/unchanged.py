"""The commander for scripts as they stand: where MoveIt warns and goes on, so does this."""

import logging
from collections.abc import Callable
from typing import Any

from trajopt.ros.commander.move_group import MoveGroupCommander
from trajopt.ros.commander.planning_scene_interface import PlanningSceneInterface
from trajopt.ros.commander.robot import RobotCommander
from trajopt.server.move_group.outcome import MoveItCommanderException

_LOG = logging.getLogger("trajopt.ros.commander")


def _or_warn(change: Callable[[], None], consequence: str) -> None:
    try:
        change()
    except MoveItCommanderException as error:
        _LOG.warning("%s; %s", error, consequence)


class UnchangedMoveGroup(MoveGroupCommander):
    """A group whose script may name OMPL's planners: they are not here, and trajopt's plans."""

    def set_planner_id(self, planner_id: str) -> None:
        """Choose a method of planning; the usual one stays, with a warning, where there is none so named."""
        choose = super().set_planner_id
        _or_warn(lambda: choose(planner_id), "trajopt's own plans")

    def set_planning_pipeline_id(self, planning_pipeline: str) -> None:
        """Choose the pipeline; the one there is stays, with a warning, where another is named."""
        choose = super().set_planning_pipeline_id
        _or_warn(lambda: choose(planning_pipeline), "trajopt's own plans")

    def execute(self, trajectory: Any, wait: bool = True) -> bool:
        """Execute a motion, or all that `plan` returned: until 2020 that was the motion alone."""
        return super().execute(trajectory[1] if isinstance(trajectory, tuple) else trajectory, wait)


class UnchangedRobot(RobotCommander):
    """A robot whose groups are those of scripts as they stand."""

    group_kind = UnchangedMoveGroup


class UnchangedScene(PlanningSceneInterface):
    """A scene whose script may clear away what is not there, as scripts do at their beginning."""

    def remove_world_object(self, name: str | None = None) -> None:
        """Remove an object from the world, or all; warn where there is none of that name."""
        remove = super().remove_world_object
        _or_warn(lambda: remove(name), "nothing is removed")

    def remove_attached_object(self, link: str | None = None, name: str | None = None) -> None:
        """Leave what a link carries in the world; warn where there is none of that name."""
        remove = super().remove_attached_object
        _or_warn(lambda: remove(link, name), "nothing is detached")

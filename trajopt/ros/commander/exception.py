"""`moveit_commander.exception` under the name that scripts import."""

from trajopt.server.move_group.exception import MoveItCommanderException, NoStandIn

__all__ = ["MoveItCommanderException", "NoStandIn"]

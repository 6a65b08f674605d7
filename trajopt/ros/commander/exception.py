"""`moveit_commander.exception` under the name that scripts import."""

from trajopt.server.move_group.outcome import MoveItCommanderException, NoStandIn

__all__ = ["MoveItCommanderException", "NoStandIn"]

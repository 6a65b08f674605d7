"""What a group holds on the way: path constraints, trajectory constraints, and stored ones."""

from pathlib import Path
from typing import Any

from trajopt.files.messages import decode, document_of
from trajopt.files.moveit.constraints import read_constraints
from trajopt.ros.commander.group_base import GroupBase
from trajopt.ros.commander.moveit_msgs.msg import Constraints, TrajectoryConstraints
from trajopt.ros.commander.planning import reading_in
from trajopt.values.documents.document import Node, read_document
from trajopt.values.errors import NameNotFound, ProblemError, shown


class GroupConstraints(GroupBase):
    """What a group holds on the way."""

    def get_known_constraints(self) -> list[str]:
        """Return the names of the stored constraints."""
        return sorted(self._known_constraints)

    def get_path_constraints(self) -> Constraints:
        """Return what is held all the way."""
        return self._path_constraints

    def set_path_constraints(self, value: Any) -> None:
        """Choose what is held all the way: by `plan`, and just so by `go`.

        Args:
            value: A Constraints message with joint, position, orientation and visibility constraints, the
                name of stored ones, or None for nothing.

        Raises:
            MoveItCommanderException: If they name what does not exist, or are malformed.
        """
        if value is None:
            return self.clear_path_constraints()
        if isinstance(value, str):
            if value not in self._known_constraints:
                raise NameNotFound("stored constraints", value, self._known_constraints)
            value = self._known_constraints[value]
        self._check("set_path_constraints", value)
        self._path_constraints = value
        return None

    def clear_path_constraints(self) -> None:
        """Hold nothing on the way."""
        self._path_constraints = Constraints()

    def get_trajectory_constraints(self) -> TrajectoryConstraints:
        """Return what is held on the way one after the other."""
        return self._trajectory_constraints

    def set_trajectory_constraints(self, value: Any) -> None:
        """Choose what is held on the way one after the other: waypoints.

        Args:
            value: A TrajectoryConstraints message, or None for nothing.

        Raises:
            MoveItCommanderException: If they name what does not exist, or are malformed.
        """
        if value is None:
            return self.clear_trajectory_constraints()
        for each in value.constraints:
            self._check("set_trajectory_constraints", each)
        self._trajectory_constraints = value
        return None

    def clear_trajectory_constraints(self) -> None:
        """Pass no waypoints."""
        self._trajectory_constraints = TrajectoryConstraints()

    def set_constraints_database(self, host: str, port: int) -> None:
        """Choose where stored constraints are.

        Args:
            host: A folder of `moveit_msgs/Constraints` in YAML, each known by the name of its file.
            port: As in MoveIt; a folder has none.

        Raises:
            MoveItCommanderException: If there is no such folder, or a file in it is malformed.
        """
        if not Path(host).is_dir():
            raise ProblemError(f"set_constraints_database: {shown(host)} is not a folder")
        stored: dict[str, Constraints] = {}
        for path in sorted(Path(host).glob("*.yaml")):
            document = read_document(path)
            self._read(document)
            stored[path.stem] = decode(Constraints, document)
        self._known_constraints = stored

    def _check(self, name: str, message: object) -> None:
        """Make sure that constraints can be read, before they are planned with."""
        self._read(document_of(message, name))

    def _read(self, document: Node) -> None:
        scene = self._world.scene
        read_constraints(document, scene, reading_in(scene, self._world.positions))

"""Read values from a bundle's documents; the inverse of `trajopt/files/bundle/to_document.py`."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from trajopt.files.bundle.kinds import bundle_kinds
from trajopt.files.bundle.kinematics import MOST_JOINTS, model_from
from trajopt.problem.read_checks import check_fields, check_value
from trajopt.values.documents import read_values
from trajopt.values.documents.document import Node
from trajopt.values.documents.read_values import is_mapping
from trajopt.values.errors import ShapeError

ArrayOf = Callable[[str], NDArray[np.generic]]
"""Returns an array by the name of its member."""
FileOf = Callable[[str], Path]
"""Maps a file name in the bundle to a path on disk."""


class Reader(read_values.Reader):
    """Converts documents to values: only kinds allowed in a bundle, and validated again."""

    def __init__(self, array_of: ArrayOf, file_of: FileOf) -> None:
        """Store the sources of arrays and files."""
        forms = {"file": self._file, "kinematics": self._kinematics}
        super().__init__(bundle_kinds(), check_fields, check_value, forms)
        self._array_of, self._file_of = (
            cache(array_of),
            file_of,
        )  # read each array once, however often it is named

    def array(self, node: Node) -> NDArray[np.generic]:
        """Return an array, from the document or from a separate member.

        Raises:
            FileFormatError: If it is not an array.
        """
        if isinstance(node["array"].value, str):
            return self._array_of(node.only(("array", "type"))["array"].text())
        return super().array(node)

    def _file(self, node: Node) -> Path:
        return self._file_of(node.only(("file",))["file"].text())

    def _kinematics(self, node: Node) -> pin.Model:
        stated = node.only(("kinematics",))["kinematics"]
        if len(stated["joints"].elements()) > MOST_JOINTS:
            raise stated["joints"].error(f"are more than {MOST_JOINTS}")
        tree = Node(self._tree(stated), node.path, f"{node.place}.kinematics")
        try:
            return model_from(tree)
        except ShapeError as error:
            raise node.error(str(error)) from error
        except (ValueError, RuntimeError) as error:
            raise node.error(f"is not a model of a robot: {error}") from error

    def _tree(self, node: Node) -> object:
        if isinstance(node.value, list):
            return [self._tree(item) for item in node.elements()]
        if not is_mapping(node.value):
            return node.value
        if "array" in node.value:
            return self.array(node)
        return {key: self._tree(node[key]) for key in node.value}

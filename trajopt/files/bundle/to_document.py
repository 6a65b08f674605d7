"""Convert values to the documents of a bundle; arrays and files become separate members.

The document extends the format of `trajopt/values/documents/values.py` by `{"array": name}` for an array,
`{"file": name}` for a mesh, and `{"kinematics": {...}}`.
"""

from pathlib import Path
from typing import Any, cast

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from trajopt.files.bundle.kinds import bundle_kinds
from trajopt.files.bundle.kinematics import kinematics_document
from trajopt.values.documents import values

SMALL = 64
"""Largest number of elements of an array written into the document itself, where people can read it."""


class Writer(values.Writer):
    """Converts values to documents, and collects their arrays and files.

    Attributes:
        arrays: Arrays by the name of their member.
        files: Files by the name of their member.
    """

    def __init__(self) -> None:
        """Start without members."""
        super().__init__(bundle_kinds())
        self.arrays: dict[str, NDArray[np.generic]] = {}
        self.files: dict[str, Path] = {}
        self._by_path: dict[Path, str] = {}

    def array(self, value: NDArray[np.generic], place: str) -> object:
        """Return an array as a document, or the name of its member."""
        value = values.of_known_type(value)
        if 0 < value.size <= SMALL and np.isfinite(cast("Any", value)).all():
            return super().array(value, place)
        name = f"arrays/{len(self.arrays)}.npy"
        self.arrays[name] = value
        return {"array": name}

    def other(self, value: object, place: str) -> object:
        """Return a file, a model of a robot or a value of a kind as a document.

        Raises:
            ModelError: If it is none of these.
        """
        match value:
            case Path():
                return {"file": self._file(value)}
            case pin.Model():
                return {"kinematics": self._tree(kinematics_document(value))}
            case _:
                return super().other(value, place)

    def _file(self, path: Path) -> str:
        if path not in self._by_path:
            if path.suffix.lower() == ".urdf" or not path.is_file():
                return path.name
            name = f"meshes/{len(self.files)}{path.suffix.lower()}"
            self._by_path[path], self.files[name] = name, path
        return self._by_path[path]

    def _tree(self, item: object) -> object:
        if isinstance(item, dict):
            return {key: self._tree(each) for key, each in cast("dict[str, object]", item).items()}
        if isinstance(item, list):
            return [self._tree(each) for each in cast("list[object]", item)]
        return self.document(item, "kinematics")

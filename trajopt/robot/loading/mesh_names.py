"""Resolution of mesh names in a description; ROS packages are searched as ROS does."""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path

from trajopt.robot.loading.xml_file import PACKAGE_FILE, read_xml
from trajopt.values.documents.files import is_file
from trajopt.values.errors import FileFormatError, MeshFileError, listed, shown

PACKAGE_PATHS = "ROS_PACKAGE_PATH"
"""Environment variable with the package folders of ROS 1."""
PREFIXES = "AMENT_PREFIX_PATH"
"""Environment variable with the install prefixes of ROS 2; packages are below `share`."""
_LONGEST_NAME = 4096  # characters of a file's name
_SCHEMES = ("package://", "model://")


@dataclass(frozen=True)
class MeshNames:
    """The mesh names of one description, and the given folders of packages."""

    file: Path
    package_dirs: tuple[Path, ...] = ()

    def find(self, filename: str) -> Path:
        """Return the file of a mesh name.

        Candidates, in this order: the name as an absolute path (with or without `file://`); below each
        package directory; below the description's folder and its parents; in the packages of that name: by
        the `package.xml` above the description and next to that package, below the package directories, in
        `ROS_PACKAGE_PATH` and in `AMENT_PREFIX_PATH`.

        A name with `..` (`../meshes/link.stl`), and an absolute one, must lead to a file in a package
        directory, in the description's folder, in its package (the nearest folder above with a `package.xml`,
        else the folder above), or in the named package.

        Raises:
            MeshFileError: If it does not exist, or is outside; the message lists the searched folders.
        """
        if len(filename) > _LONGEST_NAME or "\0" in filename:
            raise MeshFileError(shown(filename), f"is not a name of a file ({self.file.name})")
        name = filename.removeprefix("file://")
        scheme = next((scheme for scheme in _SCHEMES if name.startswith(scheme)), "")
        # Some write three slashes, no package: the name is meant below a folder all the same.
        relative = name.removeprefix(scheme).lstrip("/") if scheme else name
        package, _, inner = relative.partition("/")
        named = package if scheme and inner else ""
        climbs = name.startswith("/") or ".." in Path(relative).parts
        outside = False
        for root, file in self._tried(relative, inner, named, scheme):
            found = Path(os.path.normpath(file))
            if is_file(found):
                below = not climbs and root != Path(root.anchor) and found.is_relative_to(root)
                if below or self._owns(found, named):
                    return found.resolve()
                outside = True
        if outside:
            where = f"lies outside the folders of {self.file.name}; name its folder as a package directory"
            raise MeshFileError(filename, where)
        raise MeshFileError(filename, self._nowhere(self._tried(relative, inner, named, scheme), scheme))

    def _tried(self, relative: str, inner: str, named: str, scheme: str) -> Iterator[tuple[Path, Path]]:
        yield from ((root, root / relative) for root in self._roots)
        if scheme:
            # A package directory may be the package itself: its name is dropped then.
            yield from ((root, root / inner) for root in (*self._dirs, self._above[0]))
            yield from ((root, root / inner) for root in self._packages(named))

    @cached_property
    def _above(self) -> tuple[Path, ...]:
        return tuple(Path(os.path.abspath(self.file)).parents)

    @cached_property
    def _dirs(self) -> tuple[Path, ...]:
        return tuple(Path(os.path.abspath(folder)) for folder in self.package_dirs)

    @cached_property
    def _roots(self) -> tuple[Path, ...]:
        return tuple(dict.fromkeys((*self._dirs, *self._above, *self.file.parent.resolve().parents)))

    @cached_property
    def _package(self) -> Path:
        parent = self._above[min(1, len(self._above) - 1)]
        return next((folder for folder in self._above if is_file(folder / PACKAGE_FILE)), parent)

    @cached_property
    def _mine(self) -> frozenset[Path]:
        near = {folder for folder in (self._above[0], self._package) if folder != Path(folder.anchor)}
        mine = {*self._dirs, *near}
        return frozenset(mine | {folder.resolve() for folder in mine})

    def _owns(self, file: Path, named: str) -> bool:
        return any(file.is_relative_to(folder) for folder in chain(self._mine, self._packages(named)))

    @cached_property
    def _by_name(self) -> dict[str, tuple[Path, ...]]:
        return {}

    def _packages(self, name: str) -> tuple[Path, ...]:
        if name not in self._by_name:
            self._by_name[name] = tuple(dict.fromkeys(self._named(name) if name else ()))
        return self._by_name[name]

    def _named(self, name: str) -> Iterator[Path]:
        beside = () if self._package == Path(self._package.anchor) else (self._package.parent,)
        paths = _folders(PACKAGE_PATHS)
        yield from (folder for folder in self._above if _states(folder, name))
        for root in (*self._dirs, *beside, *paths):
            yield from (folder for folder in (root, *_inside(root)) if _states(folder, name))
        for folder in (
            *(root / name for root in paths),
            *(root / "share" / name for root in _folders(PREFIXES)),
        ):
            if folder.is_dir():
                yield folder

    def _nowhere(self, tried: Iterable[tuple[Path, Path]], scheme: str) -> str:
        roots = list(dict.fromkeys(str(root) for root, _ in tried))
        said = f"not found for {self.file.name}; looked below {listed(roots)}"
        if scheme:
            unset = [name for name in (PACKAGE_PATHS, PREFIXES) if not _folders(name)]
            named = [name for name in (PACKAGE_PATHS, PREFIXES) if _folders(name)]
            said += f", in packages that a {PACKAGE_FILE} near it names so"
            said += "".join(f", in {name}" for name in named)
            said += f" ({' and '.join(unset)} {'are' if len(unset) > 1 else 'is'} not set)" if unset else ""
        return f"{said}; name its package directory"


def _folders(variable: str) -> tuple[Path, ...]:
    return tuple(Path(each) for each in os.environ.get(variable, "").split(os.pathsep) if each)


def _inside(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            found = [Path(entry.path) for entry in entries if is_file(Path(entry.path) / PACKAGE_FILE)]
    except OSError:
        return []
    return sorted(found)


def _states(folder: Path, name: str) -> bool:
    file = folder / PACKAGE_FILE
    if not is_file(file):
        return False
    try:
        root = read_xml(file, "package file", root="package")
    except FileFormatError:
        return False
    return (root.findtext("name") or "").strip() == name

"""No file and no folder needs itself by way of others; rooms are few in a layer."""

from pathlib import Path

from tests.architecture.import_graph import PACKAGE, circles, file_graph, folder_graph, modules
from tests.architecture.test_layers import ORDER

FILES_AT_THE_TOP = 8
ROOMS_IN_A_LAYER = 6


def test_no_file_needs_itself() -> None:
    assert circles(file_graph()) == []


def test_no_room_needs_itself() -> None:
    rooms = {module for module in modules() if module.count(".") == 1}
    graph = folder_graph(file_graph(), 1)
    assert circles({room: graph[room] & rooms for room in rooms}) == []


def test_no_folder_within_a_room_needs_itself() -> None:
    folders = {module for module, path in modules().items() if path.name == "__init__.py"} - {"trajopt"}
    graph = folder_graph(file_graph(), 2)
    inner = {folder: graph[folder] & folders for folder in folders if folder in graph}
    assert circles(inner) == []


def test_circles_are_seen(tmp_path: Path) -> None:
    package = tmp_path / "house"
    for folder in ("", "attic", "cellar"):
        (package / folder).mkdir()
        (package / folder / "__init__.py").touch()
    (package / "attic" / "lamp.py").write_text("def light():\n    from house.cellar import fuse\n")
    (package / "cellar" / "fuse.py").write_text(
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from house.attic.roof import Roof\n"
    )
    (package / "attic" / "roof.py").touch()
    graph = file_graph(package)
    assert circles(graph) == []
    assert circles(folder_graph(graph, 1)) == [{"house.attic", "house.cellar"}]
    (package / "attic" / "roof.py").write_text("import house.attic.lamp\n")
    assert circles(file_graph(package)) == [{"house.attic.lamp", "house.attic.roof", "house.cellar.fuse"}]


def test_few_files_are_at_the_top() -> None:
    files = {path.name for path in PACKAGE.glob("*.py")} - {"__init__.py", "__main__.py"}
    assert len(files) <= FILES_AT_THE_TOP, sorted(files)


def test_few_rooms_share_a_layer() -> None:
    assert max(len(rooms) for rooms in ORDER) <= ROOMS_IN_A_LAYER

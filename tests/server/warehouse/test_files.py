"""Files that are no warehouse, newer, damaged or made by somebody else are refused, and say so."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

import trajopt as to
from trajopt.server.warehouse import StoredState, Warehouse
from trajopt.server.warehouse.database import APPLICATION, VERSION
from trajopt.values.errors import FileFormatError, ModelError


def change(path: Path, *statements: str) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        for statement in statements:
            connection.execute(statement)
    connection.close()


@pytest.fixture
def path(kept: Warehouse, cell: to.Scene) -> Path:
    kept.add("cell", cell)
    kept.close()
    return kept.path


def test_a_missing_file_is_made_only_where_that_is_meant(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="there is no such file"):
        Warehouse(tmp_path / "none", create=False)
    assert not (tmp_path / "none").exists()
    with Warehouse(tmp_path / "folder" / "new") as new:
        assert new.find() == ()


def test_refuses_a_file_that_is_not_a_database(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("no database at all, but long enough to be looked at" * 100)
    with pytest.raises(FileFormatError, match="is not a warehouse"):
        Warehouse(tmp_path / "text")
    with pytest.raises(FileFormatError, match="cannot be used"):
        Warehouse(tmp_path)


def test_a_database_of_something_else_is_left_alone(tmp_path: Path) -> None:
    other = tmp_path / "other.db"
    change(other, "CREATE TABLE orders (id INTEGER)")
    before = other.read_bytes()
    with pytest.raises(FileFormatError, match="a database of something else"):
        Warehouse(other)
    assert other.read_bytes() == before


def test_a_newer_format_is_refused(path: Path) -> None:
    change(path, f"PRAGMA user_version = {VERSION + 1}")
    with pytest.raises(FileFormatError, match=f"is of format {VERSION + 1}.*newer"):
        Warehouse(path)


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("DROP TABLE tags", "'tags' is missing or another"),
        ("CREATE TRIGGER t AFTER INSERT ON entries BEGIN DELETE FROM entries; END", "code of its own"),
        ("CREATE VIEW v AS SELECT 1", "code of its own"),
    ],
)
def test_tables_of_somebody_else_are_refused(path: Path, statement: str, words: str) -> None:
    change(path, statement)
    with pytest.raises(FileFormatError, match=words):
        Warehouse(path)


def test_an_empty_file_becomes_a_warehouse(tmp_path: Path) -> None:
    (tmp_path / "empty").touch()
    with Warehouse(tmp_path / "empty") as kept:
        assert kept.find() == ()
    with closing(sqlite3.connect(tmp_path / "empty")) as connection, connection:
        assert connection.execute("PRAGMA application_id").fetchone()[0] == APPLICATION
    connection.close()


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("UPDATE contents SET packed = x'00'", "damaged"),
        ("UPDATE contents SET packed = 'text'", "damaged"),
        ("UPDATE contents SET size = size - 1", "damaged"),
        ("UPDATE contents SET size = 1 << 40", "holds more than"),
        ("UPDATE contents SET size = 'text'", "the size of a member is not a number"),
        ("UPDATE members SET name = 'meshes/..' WHERE name = 'value.json'", "of a name that no entry has"),
        ("DELETE FROM members", "has no member 'value.json'"),
    ],
)
def test_damaged_contents_are_named(path: Path, statement: str, words: str) -> None:
    change(path, statement)
    with Warehouse(path) as kept, pytest.raises(FileFormatError, match=words):
        kept.scene("cell")


def test_a_schema_that_is_not_text_is_damaged(path: Path) -> None:
    bad = "CAST(x'e5ff' AS TEXT)"
    change(path, "PRAGMA writable_schema = ON", f"UPDATE sqlite_master SET name = {bad}, sql = {bad}")
    with pytest.raises(FileFormatError, match="damaged"):
        Warehouse(path)


@pytest.mark.parametrize("ends", ["nonsense", "[]", '{"joint1": "far"}', "1"])
def test_the_end_of_a_motion_is_checked(path: Path, ends: str) -> None:
    change(path, f"UPDATE entries SET ends = '{ends}'")
    with Warehouse(path) as kept, pytest.raises(FileFormatError, match="the end of a motion is damaged"):
        kept.find(goal={"joint1": 0.1})


@pytest.mark.parametrize("column", ["kind", "version", "duration"])
def test_reports_a_damaged_column(path: Path, column: str) -> None:
    change(path, f"UPDATE entries SET {column} = 'nonsense'")
    with Warehouse(path) as kept, pytest.raises(FileFormatError, match=r"damaged.*nonsense"):
        kept.find()


def test_only_the_owner_can_read_a_new_file(path: Path) -> None:
    with Warehouse(path) as kept:
        kept.find()
        modes = {each.name: each.stat().st_mode & 0o777 for each in path.parent.glob(f"{path.name}*")}
    assert modes and set(modes.values()) == {0o600}, modes


def test_an_empty_file_is_not_opened_as_a_warehouse(tmp_path: Path) -> None:
    (tmp_path / "empty").touch()
    with pytest.raises(FileFormatError, match="is empty"):
        Warehouse(tmp_path / "empty", create=False)
    assert (tmp_path / "empty").read_bytes() == b""


def test_pages_that_were_overwritten_are_named(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[4096:] = bytes(len(data) - 4096)
    path.write_bytes(bytes(data))
    with pytest.raises(FileFormatError, match=r"damaged|not a warehouse|cannot be used"):
        Warehouse(path).find()


def test_a_failed_write_leaves_no_file(
    kept: Warehouse, cell: to.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept.add("cell", cell)

    def full(*given: object) -> None:
        raise sqlite3.OperationalError("database or disk is full")

    with monkeypatch.context() as patched:
        patched.setattr("trajopt.server.warehouse.rows.keep_members", full)
        with pytest.raises(FileFormatError, match="disk is full"):
            kept.add("cell", cell)
    assert [entry.version for entry in kept.find()] == [1]
    assert kept.add("cell", cell).version == 2


def test_another_that_writes_too_long_is_named(
    path: Path, cell: to.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trajopt.server.warehouse.database.PATIENCE", 0.05)
    blocker = sqlite3.connect(path, isolation_level=None)
    blocker.execute("BEGIN IMMEDIATE")
    with Warehouse(path) as kept:
        assert len(kept.find()) == 1  # readers do not wait
        with pytest.raises(FileFormatError, match="another process has been writing"):
            kept.add("cell", cell)
        blocker.execute("ROLLBACK")
        blocker.close()
        assert kept.add("cell", cell).version == 2
    blocker.close()


def test_a_stranger_cannot_put_a_bundle_of_nonsense_in(kept: Warehouse, tmp_path: Path) -> None:
    (tmp_path / "x.trajopt").write_bytes(b"PK nothing")
    refused: list[Callable[[], object]] = [
        lambda: kept.add_bundle(tmp_path / "x.trajopt"),
        lambda: kept.add_bundle(tmp_path / "none.trajopt"),
    ]
    for call in refused:
        with pytest.raises(FileFormatError):
            call()
    assert kept.find() == ()


SURROGATE = "\ud800"


@pytest.mark.parametrize(
    "use",
    [
        lambda kept, cell: kept.add("cell", cell, note=SURROGATE),
        lambda kept, _: kept.find(text=SURROGATE),
        lambda kept, _: kept.find(name=SURROGATE),
        lambda kept, _: kept.entry(SURROGATE),
        lambda kept, _: kept.add("stand", StoredState("arm", {SURROGATE: 0.1})),
        lambda kept, _: kept.add("stand", StoredState(SURROGATE, {})),
    ],
    ids=["note", "text", "name", "entry", "joint", "robot"],
)
def test_a_lone_surrogate_is_refused(
    use: Callable[[Warehouse, to.Scene], object], kept: Warehouse, cell: to.Scene
) -> None:
    with pytest.raises(ModelError, match="UTF-8 cannot encode"):
        use(kept, cell)
    assert kept.find() == ()


def test_a_name_with_a_zero_is_refused() -> None:
    with pytest.raises(FileFormatError, match="zero character"):
        Warehouse("kept\0.trj")

"""Small files that once hung, crashed or lost what they said: a typed error that names file and place."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import trajopt as to
from trajopt.files.moveit import read_request, read_scene, read_trajectory
from trajopt.files.moveit.objects import read_kind, read_operation
from trajopt.robot.loading.stated_limits import read_joint_limits
from trajopt.values.documents.document import Node, read_document
from trajopt.values.documents.files import read_json
from trajopt.values.documents.yaml_files import MOST_ALIASED, read_yaml
from trajopt.values.errors import SHOWN_LENGTH, FileFormatError, TrajoptError, shown

pytestmark = pytest.mark.timeout(60)


def bomb(levels: int = 9) -> str:
    """Return flow lists, each of nine aliases of the one before, as lines of a YAML mapping."""
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    for level in range(1, levels):
        lines.append(f"a{level}: &a{level} [{', '.join([f'*a{level - 1}'] * 9)}]")
    return "\n".join(lines) + "\n"


def merge_bomb(levels: int = 9) -> str:
    lines = ["a0: &a0 {x: 1, y: 2}"]
    for level in range(1, levels):
        lines.append(f"a{level}: &a{level} {{<<: [{', '.join([f'*a{level - 1}'] * 9)}]}}")
    return "\n".join(lines) + "\n"


def nested(depth: int) -> object:
    value: list[object] = []
    for _ in range(depth):
        value = [value]
    return value


def shared(depth: int) -> object:
    value: list[object] = ["x"] * 9
    for _ in range(depth):
        value = [value] * 9
    return value


HUGE: dict[str, object] = {
    "a list of lists of the same": shared(30),
    "deep": nested(100_000),
    "a long text": "x" * 10**7,
    "long bytes": b"x" * 10**7,
    "a number of 5000 digits": 10**5000,
    "a mapping": {"key": shared(30)},
}


@pytest.mark.parametrize("name", HUGE)
def test_a_value_in_a_message_is_cut_before_it_is_written(name: str, planar_arm: to.Robot) -> None:
    value = HUGE[name]
    assert len(shown(value)) <= SHOWN_LENGTH
    calls: tuple[Callable[[], object], ...] = (
        lambda: to.load_mesh([value]),  # pyright: ignore
        lambda: to.Budget(attempts=[value]),  # pyright: ignore
        lambda: to.Scene(planar_arm).add("a", to.Box(1, 1, 1), frame=str(name) * 10**6),
        lambda: read_operation(Node({"operation": [value]}, "small.yaml")["operation"]),
        lambda: read_kind(Node({"type": value, "dimensions": []}, "small.yaml")),
    )
    for call in calls:
        with pytest.raises(TrajoptError) as refused:
            call()
        assert len(str(refused.value)) < 300


def test_a_short_value_is_shown_whole() -> None:
    for value in (None, 1, -2.5, "a", [1, 2, 3], {"a": [1]}, ("x",), 10**40):
        assert shown(value) == repr(value)


YAML: dict[str, tuple[str, str]] = {
    "alias bomb": (bomb(), "aliases"),
    "alias of what it is in": ("world: &w [*w]", "aliases"),
    "merge bomb": (merge_bomb(40).replace("x: 1, y: 2", ", ".join(f"k{i}: 1" for i in range(9))), ""),
    "merge of itself": ("a: &a {<<: *a}", "parsed"),
    "two blocks of one name": ("world: {a: 1}\nname: x\nworld: {}\n", "line 3.*'world'.*line 1"),
    "twice below": ("a:\n  b: {c: 1,\n    c: 2}\n", "line 3.*'c'"),
    "number of 5000 digits": (f"a: {'9' * 5000}", "parsed"),
    "base sixty": (f"a: {'1:' * 400}1.5", "parsed"),
    "no truth": ("a: !!bool maybe", "parsed"),
    "no time": ("a: !!timestamp soon", "parsed"),
    "no whole number": ("a: !!int ''", "parsed"),
    "unknown tag": ("a: !!python/object:os.system x", "parsed"),
    "deep brackets": ("a: " + "[" * 100_000, "nested"),
    "deep dashes": ("- " * 100_000, "nested"),
    "deep questions": ("? " * 100_000, "nested"),
    "deep tabs": ("-\t" * 100_000, "nested"),
    "deep indentation": ("".join(f"{' ' * i}a:\n" for i in range(2000)), "nested"),
    "unclosed": ("a: [1, 2", "parsed"),
    "a zero": ("a: \x00", "parsed"),
}


@pytest.mark.parametrize("name", YAML)
def test_yaml_that_no_reader_takes(name: str, tmp_path: Path, planar_arm: to.Robot) -> None:
    text, reason = YAML[name]
    path = tmp_path / "small.yaml"
    path.write_text(text)
    if name == "merge bomb":
        assert len(read_yaml(path)[0]) == 40, "of a key merged often one stays"  # pyright: ignore
        return
    with pytest.raises(FileFormatError, match=rf"(?s)small\.yaml.*{reason}"):
        read_yaml(path)
    readers: tuple[Callable[[], object], ...] = (
        lambda: read_scene(path, planar_arm),
        lambda: read_request(path, to.Scene(planar_arm)),
        lambda: read_joint_limits(path),
        lambda: read_trajectory(path),
    )
    for read in readers:
        with pytest.raises(FileFormatError, match=r"small\.yaml"):
            read()


def test_aliases_and_merges_in_measure_are_read(tmp_path: Path) -> None:
    path = tmp_path / "limits.yaml"
    path.write_text(
        "usual: &usual {max_velocity: 2.0, max_acceleration: 5.0}\n"
        "joint_limits:\n  a: {<<: *usual, max_velocity: 1.0}\n  b: *usual\n  c: {<<: [*usual]}\n"
    )
    assert read_joint_limits(path) == {
        "a": {"max_velocity": 1.0, "max_acceleration": 5.0},
        "b": {"max_velocity": 2.0, "max_acceleration": 5.0},
        "c": {"max_velocity": 2.0, "max_acceleration": 5.0},
    }


def test_a_large_file_with_few_aliases_is_read(tmp_path: Path) -> None:
    path = tmp_path / "large.json.yaml"
    numbers = ", ".join(["1"] * (MOST_ALIASED // 20))
    path.write_text(f"a: &a [1]\nb: [*a, *a]\nc: [{numbers}]\n")
    assert len(read_yaml(path)) == 1


JSON: dict[str, tuple[str, str]] = {
    "two of one name": ('{"points": [1], "points": []}', "'points'.*twice"),
    "deep": ("[" * 100_000, "nested"),
    "deep mappings": ('{"a":' * 100_000, "nested"),
    "number of 5000 digits": ('{"a": ' + "9" * 5000 + "}", "parsed"),
    "empty": ("", "parsed"),
    "cut off": ('{"a": [1,', "parsed"),
}


@pytest.mark.parametrize("name", JSON)
def test_json_that_no_reader_takes(name: str, tmp_path: Path) -> None:
    text, reason = JSON[name]
    path = tmp_path / "small.json"
    path.write_text(text)
    with pytest.raises(FileFormatError, match=rf"(?s)small\.json.*{reason}"):
        read_json(path)
    with pytest.raises(FileFormatError, match=r"small\.json"):
        read_trajectory(path)


@pytest.mark.parametrize("suffix", ["yaml", "json"])
def test_binary_files_are_refused(suffix: str, tmp_path: Path) -> None:
    folder = tmp_path / f"folder.{suffix}"
    folder.mkdir()
    binary = tmp_path / f"binary.{suffix}"
    binary.write_bytes(bytes(range(256)) * 4)
    empty = tmp_path / f"empty.{suffix}"
    empty.write_bytes(b"")
    names = (folder, binary, empty, tmp_path / ("x" * 5000), tmp_path / "a\0b", tmp_path / "gone")
    for path in names:
        with pytest.raises(FileFormatError):
            read_trajectory(path)


def test_a_byte_order_mark_is_skipped(tmp_path: Path) -> None:
    for suffix, read in (("json", read_json), ("yaml", read_yaml)):
        path = tmp_path / f"marked.{suffix}"
        path.write_bytes(b"\xef\xbb\xbf" + json.dumps({"a": 1}).encode())
        assert read(path) in ({"a": 1}, [{"a": 1}])


@pytest.mark.parametrize(
    ("entry", "place"),
    [
        ("{j: 3}", r"joint_limits\.j: must be a mapping"),
        ("{j: {max_velocty: 1}}", r"joint_limits\.j: unknown key 'max_velocty'; did you mean 'max_velocity'"),
        ("{j: {has_jerk_limit: true}}", r"joint_limits\.j: unknown key .* did you mean 'has_jerk_limits'"),
        ("{j: [1]}", r"joint_limits\.j: must be a mapping"),
        ("{j: {max_velocity: abc}}", r"joint_limits\.j\.max_velocity: must be a number, is 'abc'"),
        ("{j: {max_velocity: .nan}}", r"joint_limits\.j\.max_velocity"),
        ("{j: {max_velocity: -1}}", r"max_velocity: must not be negative"),
        ("{j: {max_acceleration: .inf}}", r"max_acceleration"),
        ("{j: {max_jerk: [1]}}", r"max_jerk"),
        ("{j: {has_jerk_limits: 7}}", r"has_jerk_limits: must be true or false"),
        ("{j: {min_position: 2, max_position: 1}}", "min_position 2 is above max_position 1"),
        (f"{{j: {{max_position: {10**400}}}}}", r"max_position"),
        ("3", "must be a mapping"),
        ("{j: {max_velocity: 1, max_velocity: 2}}", "'max_velocity' is there twice"),
    ],
)
def test_joint_limits_of_the_wrong_kind(entry: str, place: str, tmp_path: Path) -> None:
    path = tmp_path / "joint_limits.yaml"
    path.write_text(f"joint_limits: {entry}\n")
    with pytest.raises(FileFormatError, match=rf"(?s)joint_limits\.yaml.*{place}"):
        read_joint_limits(path)


def test_a_number_with_an_exponent_and_no_point_is_a_limit(tmp_path: Path) -> None:
    path = tmp_path / "joint_limits.yaml"
    path.write_text("joint_limits: {j: {max_velocity: 1e1}}\n")
    assert read_joint_limits(path)["j"]["max_velocity"] == 10.0


def test_joint_limits_may_have_keys_of_other_programs(tmp_path: Path) -> None:
    path = tmp_path / "joint_limits.yaml"
    path.write_text("joint_limits: {j: {max_velocity: 1, max_deceleration: 2, angle_wraparound: true}}\n")
    assert read_joint_limits(path) == {"j": {"max_velocity": 1.0}}


def test_a_number_like_name_is_kept_as_a_key_and_reported_as_a_value(tmp_path: Path) -> None:
    file = tmp_path / "named.yaml"
    file.write_text("joints: {3: 0.1, off: 0.2, 1.50: 0.3}\nid: 3\n")
    node = read_document(file)
    assert {name: each.number() for name, each in node["joints"].members().items()} == {
        "3": 0.1,
        "off": 0.2,
        "1.50": 0.3,
    }
    with pytest.raises(
        FileFormatError, match=r"id: must be text, is 3 \(YAML reads it so unless it is quoted"
    ):
        node["id"].text()
    file.write_text("joints: {3: 0.1, '3': 0.2}\n")
    with pytest.raises(FileFormatError, match="the key '3' is there twice"):
        read_document(file)


def test_a_control_character_is_reported_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "zeros.yaml").write_text("a: 1\0")
    with pytest.raises(FileFormatError, match=r"^.*not allowed at position 4$"):
        read_document(tmp_path / "zeros.yaml")

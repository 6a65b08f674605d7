"""Allowed-collision matrices of planning scene files."""

from collections.abc import Callable

import pytest

from trajopt.files.moveit import SceneFile
from trajopt.values.errors import FileFormatError

Read = Callable[[str], SceneFile]

BALL = "world: {collision_objects: [{id: ball, primitives: [{type: sphere, dimensions: [0.1]}]}]}"
LINKS = "[base, upper, fore, hand, left_finger, right_finger]"


def matrix(text: str) -> str:
    return f"{BALL}\nallowed_collision_matrix: {text}"


def test_none_leaves_the_robots_own(scene_of: Read) -> None:
    scene = scene_of(BALL).scene
    assert scene.may_touch("hand", "left_finger")
    assert scene.may_touch("upper", "fore")
    assert not scene.may_touch("hand", "ball")


@pytest.mark.parametrize(
    "values", ["[[false, true], [true, false]]", "[{enabled: [false, true]}, {enabled: [true, 0]}]"]
)
def test_a_matrix_in_either_form_is_read(scene_of: Read, values: str) -> None:
    file = scene_of(matrix(f"{{entry_names: [hand, ball], entry_values: {values}}}"))
    assert file.scene.may_touch("hand", "ball")
    assert not file.scene.may_touch("fore", "ball")
    assert "does not name base, upper, fore, left_finger, right_finger: their" in file.notes[0]


def test_replaces_entries_of_the_named_links_only(scene_of: Read) -> None:
    values = "[[false, false, false], [false, false, false], [false, false, false]]"
    scene = scene_of(matrix(f"{{entry_names: [hand, fore, upper], entry_values: {values}}}")).scene
    assert scene.robot.disabled_pairs >= {frozenset(("upper", "fore")), frozenset(("hand", "left_finger"))}
    assert not scene.may_touch("upper", "fore")
    assert scene.may_touch("hand", "left_finger")
    assert not scene.may_touch("base", "hand")


def test_all_false_allows_nothing(scene_of: Read) -> None:
    row = "[" + ", ".join(["false"] * 6) + "]"
    file = scene_of(matrix(f"{{entry_names: {LINKS}, entry_values: [{', '.join([row] * 6)}]}}"))
    links = file.scene.robot.links
    assert not any(file.scene.may_touch(a, b) for a in links for b in links)
    assert not file.notes


def test_unknown_names_are_left_out(scene_of: Read) -> None:
    file = scene_of(
        matrix(
            "{entry_names: [hand, box_link], entry_values: [[false, true], [true, false]], "
            "default_entry_names: [<octomap>], default_entry_values: [true]}"
        )
    )
    assert "<octomap>, box_link" in file.notes[0]
    names = {name for pair in file.scene.allowed.entries for name in pair}
    assert names <= set(file.scene.robot.links)
    assert not file.scene.allowed.defaults


def test_entries_come_before_defaults(scene_of: Read) -> None:
    scene = scene_of(
        matrix(
            "{entry_names: [hand, ball], entry_values: [[false, false], [false, false]], "
            "default_entry_names: [ball], default_entry_values: [true]}"
        )
    ).scene
    assert not scene.may_touch("hand", "ball")
    assert scene.may_touch("fore", "ball")


def test_both_defaults_must_allow(scene_of: Read) -> None:
    scene = scene_of(matrix("{default_entry_names: [ball, hand], default_entry_values: [true, false]}")).scene
    assert not scene.may_touch("hand", "ball")
    assert scene.may_touch("fore", "ball")


def test_defaults_alone_leave_the_robots_pairs(scene_of: Read) -> None:
    scene = scene_of(
        matrix("{default_entry_names: [left_finger, hand], default_entry_values: [true, false]}")
    ).scene
    assert scene.may_touch("hand", "left_finger")
    assert scene.may_touch("upper", "fore")
    assert scene.may_touch("base", "left_finger")


def test_object_can_be_allowed_later(scene_of: Read) -> None:
    scene = scene_of(
        matrix("{entry_names: [hand, ball], entry_values: [[false, false], [false, false]]}")
    ).scene
    assert scene.allow("ball").may_touch("hand", "ball")


def test_upper_half_counts(scene_of: Read) -> None:
    file = scene_of(matrix("{entry_names: [hand, ball], entry_values: [[false, true], [false, false]]}"))
    assert file.scene.may_touch("ball", "hand")
    assert any("the row of hand counts" in note for note in file.notes)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{entry_names: [hand, ball], entry_values: [[true, true]]}", "1 rows for 2 names"),
        ("{entry_names: [hand], entry_values: [[true, true]]}", r"\[0\]: 2 values for 1 names"),
        ("{entry_names: [hand, hand], entry_values: []}", "twice"),
        ("{entry_names: [hand], entry_values: [[maybe]]}", "must be true or false"),
        ("{default_entry_names: [hand]}", "1 names, but 0 values"),
        ("{entries: []}", "unknown key 'entries'"),
    ],
)
def test_bad_matrix(scene_of: Read, text: str, message: str) -> None:
    with pytest.raises(FileFormatError, match=message):
        scene_of(matrix(text))

"""Names and texts that UTF-8 cannot encode are refused where they enter."""

import pytest

import trajopt as to
from trajopt.values.documents.files import parse_json
from trajopt.values.errors import FileFormatError, ModelError

LONE = "cup\ud800"


def test_scene_rejects_names_that_files_cannot_hold(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm)
    with pytest.raises(ModelError, match="UTF-8"):
        scene.add(LONE, to.Sphere(0.1))
    with pytest.raises(ModelError, match="UTF-8"):
        scene.add("ball", to.Sphere(0.1)).with_tool(LONE, on="ball")
    assert scene.add("Tasse \N{HOT BEVERAGE} \U0001f980", to.Sphere(0.1)).objects


def test_problem_rejects_names_that_files_cannot_hold(planar_arm: to.Robot) -> None:
    start = dict.fromkeys(planar_arm.joint_names, 0.0)
    with pytest.raises(ModelError, match="UTF-8"):
        to.Problem(scene=to.Scene(planar_arm), start=start, goal=to.joint_positions(start), name=LONE)


@pytest.mark.parametrize("text", ['{"a": "\\ud800"}', '["\\udC00\\ud800"]', '{"\\uDfff": 1}', '"\ud800"'])
def test_json_with_a_lone_surrogate_is_refused(text: str) -> None:
    with pytest.raises(FileFormatError, match="lone surrogate"):
        parse_json(text, "request")


def test_json_with_a_pair_of_surrogates_is_read() -> None:
    assert parse_json('"\\ud83e\\udd80"', "request") == "\U0001f980"
    assert parse_json('"\\ud7ff \\ue000"', "request") == "\ud7ff \ue000"

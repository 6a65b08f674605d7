"""Every argument of the room's functions spoilt in turn: a typed error in words, or a sound answer."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.fuzz.test_junk import JUNK
from trajopt.lab import reach
from trajopt.optimise import kinematics
from trajopt.scene.reduced import ReducedModel

FREE = (-1.5, 0.1, 0.3, 0.0)


def sound(reduced: ReducedModel) -> Mapping[str, Mapping[str, object]]:
    """Arguments of sound calls, by function."""
    rng = np.random.default_rng(0)
    goal = to.joint_positions(dict(zip(reduced.joint_names, FREE, strict=True)), tolerance=0.1)
    return {
        "forward_kinematics": {"frame": "tip", "positions": FREE, "reference": "world", "offset": (0, 0, 0)},
        "frame_jacobian": {"frame": "tip", "positions": FREE, "reference": "world", "offset": (0, 0, 0)},
        "inverse_kinematics": {"goal": goal, "near": FREE, "starts": 4},
        "random_configurations": {"count": 3, "rng": rng, "margin": 0.01, "requirements": ()},
        "reach_map": {
            "frame": "tip", "count": 50, "rng": rng, "cell": 0.1, "directions": 9, "approach": (0, 0, 1),
            "reference": "world", "margin": 0.0, "length": 0.3,
        },
        "sample_table": {"frame": "tip", "count": 5, "rng": rng, "reference": "world", "margin": 0.0},
        "self_motion": {"goal": goal, "positions": FREE, "joint": "pan", "step": 0.05},
        "validity": {"positions": FREE, "requirements": (), "margin": 0.0},
    }  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [
        *("forward_kinematics", "frame_jacobian", "inverse_kinematics", "random_configurations"),
        *("reach_map", "sample_table", "self_motion", "validity"),
    ],
)
def test_spoilt_arguments_are_refused_in_words_or_taken_soundly(name: str, odd: ReducedModel) -> None:
    function: Callable[..., object] = getattr(reach if hasattr(reach, name) else kinematics, name)
    given = dict(sound(odd)[name])
    if name == "self_motion":
        given["goal"] = to.frame_placement(
            "tip",
            kinematics.forward_kinematics(odd, "tip", FREE)[0],
            rotation_tolerance=np.inf,
            position_tolerance=(np.inf, np.inf, 1e-3),
        )
    function(odd, **given)
    for argument in given:
        if argument == "rng":
            continue
        for junk in JUNK:
            try:
                function(odd, **{**given, argument: junk})
            except to.TrajoptError as error:
                assert str(error).strip(), f"{name}({argument}={junk!r}): an error without words"
            except Exception as error:
                pytest.fail(f"{name}({argument}={junk!r}) raised {type(error).__name__}: {error}")


def test_invalid_files_are_refused(tmp_path: Path) -> None:
    for read in (reach.read_table, reach.ReachMap.load):
        for path in (tmp_path, tmp_path / "nothing.npz", ""):
            with pytest.raises(to.TrajoptError):
                read(path)

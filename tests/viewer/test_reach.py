"""The picture of a reach map."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.lab.reach import reach_map
from trajopt.optimise.kinematics import reduce_model
from trajopt.viewer import plot_reach


def test_cuts_show_reached_cells(tmp_path: Path) -> None:
    robot = odd_arm(tmp_path)
    reduced = reduce_model(to.Scene(robot), "all", robot.positions())
    few, many = (reach_map(reduced, "tip", n, rng=np.random.default_rng(0), cell=0.1) for n in (5, 5000))
    images = [
        np.asarray(Image.open(plot_reach(found, tmp_path / name)))
        for found, name in ((few, "few"), (many, "many"))
    ]
    coloured = [
        float((image[..., :3].max(axis=2) - image[..., :3].min(axis=2) > 30).mean()) for image in images
    ]
    assert coloured[1] > coloured[0] + 0.1
    with pytest.raises(to.TrajoptError, match=r"known: .*png"):
        plot_reach(few, tmp_path / "map.xlsx")

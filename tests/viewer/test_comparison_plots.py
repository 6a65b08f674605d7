"""Figures of a comparison: drawn from what there is, each method in a colour of its own."""

from base64 import b64decode
from dataclasses import replace
from io import BytesIO

import numpy as np
from PIL import Image

from tests.lab.suite.comparison.runs_for_tests import ALL, REFUSED
from trajopt.lab.suite import RunOutcome
from trajopt.viewer.palette import LINES
from trajopt.viewer.plots import comparison_figures


def images(runs: tuple[RunOutcome, ...]) -> list[np.ndarray]:
    return [
        np.asarray(Image.open(BytesIO(b64decode(uri.split(",")[1]))))
        for uri in comparison_figures(runs).values()
    ]


def drawn(image: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((np.abs(image[..., :3].astype(int) - colour).max(axis=-1) < 12).sum())


def test_both_methods_are_in_every_figure() -> None:
    found = images(ALL)
    assert len(found) == 3
    for image in found:
        assert drawn(image, LINES[0]) > 50 and drawn(image, LINES[1]) > 20


def test_without_steps_or_motions_only_the_profile_is_drawn() -> None:
    assert len(images((REFUSED,))) == 1


def test_many_methods_have_distinct_styles() -> None:
    many = tuple(replace(run, solver=f"{run.solver} {number}") for number in range(9) for run in ALL[:4])
    for image in images(many):
        assert all(drawn(image, colour) > 20 for colour in LINES)

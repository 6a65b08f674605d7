"""Terms of frames in the core have the rows that they have in Python."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.optimise.transcription.both_ways import GOAL, START, descent_of, program, same
from tests.robots_for_tests import odd_arm
from trajopt.optimise import terms
from trajopt.optimise.nlp import ConstraintRows, CostRows
from trajopt.optimise.solvers.parts import FramePart

AT = to.placement((0.3, 0.1, 0.2), rpy=(0.4, -0.3, 2.0))
REGIONS = [
    (to.Box(0.3, 0.2, 0.1), AT),
    (to.Sphere(0.2), to.placement((0.5, -0.3, 0.3))),
    (to.Cylinder(0.1, 0.4), to.placement((0.4, 0.4, 0.2), rpy=(0.3, 0.2, 0.0))),
]
FRAMES = {
    "axis": to.axis_alignment("tip", axis=(1, 0, 0), direction=(0, 1, 1), tolerance=0.5),
    "axis in a moving frame": to.axis_alignment("tip", axis=(1, 0, 0), tolerance=0.5, reference="slide"),
    "axis turned around": to.axis_alignment("turret", direction=(0, 0, -1), tolerance=3.14),
    "axis that stays": to.axis_alignment("turret", tolerance=0.5),
    "placement": to.frame_placement("finger", AT, offset=(0.1, 0.0, 0.2), rotation_tolerance=2.0),
    "half a turn": to.frame_placement(
        "slide", to.placement(), reference="fore", rotation_tolerance=2.0, position_tolerance=0.1
    ),
    "angles": to.frame_placement(
        "tip", AT, coordinates=to.RotationCoordinates.XYZ_EULER, rotation_tolerance=(0.1, np.inf, 2.0)
    ),
    "distance": to.distance_between("tip", "turret", lower=0.1, upper=0.3, first_offset=(0.0, 0.1, 0.0)),
    "no distance": to.distance_between("turret", "base", lower=0.1, upper=0.3, second_offset=(0.0, 0.0, 0.1)),
    "gaze": to.gaze("tip", (0.5, 0.5, 0.5), angle=0.3, axis=(1, 0, 0), nearest=0.1, farthest=0.4),
    "gaze at what moves": to.gaze("base", (0.1, 0.0, 0.0), angle=0.3, reference="tip"),
    "regions": to.position_in_region("tip", REGIONS, offset=(0.0, 0.0, 0.1)),
    "half-space": to.position_in_region("finger", to.Plane(), AT, reference="turret"),
}


@pytest.mark.parametrize("name", FRAMES)
def test_terms_of_frames_are_as_python_has_them(tmp_path: Path, name: str) -> None:
    problem = to.Problem(
        scene=to.Scene(odd_arm(tmp_path)),
        start=START,
        goal=to.joint_positions(GOAL),
        costs=[terms.Cost(item.residual, 0.7) for item in items(tmp_path, name)],
    )
    seed, nlp = program(problem)
    nlp.constraints += items(tmp_path, name)
    x = seed + np.random.default_rng(3).normal(0.0, 1.0, seed.shape)
    x[5, 2], x[6, 2], x[7, 2] = 0.0, np.pi, np.pi - 1e-6
    sampling = np.full(len(x) - 1, 2)
    parts = nlp.compiled(sampling)
    assert parts is not None and all(isinstance(part, FramePart) for part in parts.costs)
    run = descent_of(nlp, sampling)
    assert run is not None
    run.begin(x, sampling)
    native = run.linearised()
    nlp.restart()
    python = nlp.linearise(x, sampling)
    for mine, theirs in zip(
        (*native.costs, *native.constraints), (*python.costs, *python.constraints), strict=True
    ):
        same(in_order(mine), in_order(theirs))
    assert sum(len(block.rows.value) for block in native.costs) >= len(x) * 2 - 1


def in_order(block: CostRows | ConstraintRows) -> dict[str, object]:
    """Return the arrays of a block, its rows by sample and component: Python has members in turn."""
    rows = block.rows
    order = np.lexsort((rows.component, rows.place))
    arrays = {**vars(block), **vars(rows)}
    return {name: value[order] for name, value in arrays.items() if isinstance(value, np.ndarray)}


def items(folder: Path, name: str) -> tuple[terms.Constraint, ...]:
    """Return a requirement as constraints, in the middle and on the whole path."""
    reduced = to.Problem(scene=to.Scene(odd_arm(folder)), start=START, goal=to.joint_positions(GOAL)).reduced
    windows = (terms.Window(), terms.Window(0.3, 0.6))
    return tuple(item for window in windows for item in terms.constrain(FRAMES[name], reduced, window))

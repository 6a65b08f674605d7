"""Points on circles and arcs: formulas, verdicts, and what every kind is asked."""

import numpy as np
import pytest
from hypothesis import given

import trajopt as to
import trajopt.optimise.terms
from tests.optimise.terms.worlds import World
from tests.problem.requirements.kind import Kind
from tests.problem.requirements.sound import (
    MANY_CONFIGURATIONS,
    TIP_OFFSET,
    check,
    points,
    positions,
    rpys,
    tip,
    verdict,
    violation,
)
from tests.verify.arms import quintic
from trajopt.optimise.terms.positions import ArcCoordinates
from trajopt.problem.requirements import (
    PointOnArc,
    point_on_arc,
)
from trajopt.problem.residual import Residual
from trajopt.scene.reduced import ReducedModel
from trajopt.values.errors import ProblemError
from trajopt.values.placement import Placement
from trajopt.verify import When


@MANY_CONFIGURATIONS
@given(at=positions, where=points, rpy=rpys)
def test_arcs(
    odd: ReducedModel, at: tuple[float, ...], where: tuple[float, ...], rpy: tuple[float, ...]
) -> None:
    """Off a circle as densely sampled, and within the tolerance of the arc where the rows hold."""
    placed = to.placement(where, rpy=rpy)
    point = placed.inverse() * tip(odd, at)
    for sweep in (2.0 * np.pi, 2.0):
        angle = np.linspace(0.0, sweep, 20001)
        ring = 0.3 * np.stack((np.cos(angle), np.sin(angle), 0.0 * angle), axis=1)
        expected = float(np.linalg.norm(ring - point, axis=1).min())
        within = max(0.9 * expected, 1e-3)
        need = to.point_on_arc(
            "tip", placed, radius=0.3, sweep=sweep, tolerance=min(within, 0.29), offset=TIP_OFFSET
        )
        assert violation(odd, need, at) > 0.0 or expected < 1e-3
        if sweep > 3.0 and expected < 0.25:
            assert violation(odd, need, at) == pytest.approx(expected - need.tolerance, abs=1e-6)


def test_a_corner_of_a_circle_is_cut(gantry: ReducedModel) -> None:
    """A straight way between two points of a circle leaves it by the height of the chord."""
    chord = quintic(gantry, [[0.5, 0.0], [0.5 * np.cos(0.4), 0.5 * np.sin(0.4)]], 1.0)
    height = 0.5 * (1.0 - np.cos(0.2))
    for factor, holds in ((1.001, True), (0.999, False)):
        wanted = point_on_arc("b", Placement(), radius=0.5, sweep=1.0, tolerance=factor * height)
        assert verdict(gantry, chord, wanted)[0] == holds
    short = point_on_arc("b", Placement(), radius=0.5, sweep=0.3, tolerance=height * 1.001)
    holds, worst = verdict(gantry, chord, short)
    assert not holds
    end = 0.5 * np.array((np.cos(0.4) - np.cos(0.3), np.sin(0.4) - np.sin(0.3)))
    reached = check(gantry, chord, short, When.END)[0]
    assert reached.value == pytest.approx(np.linalg.norm(end))
    assert worst.value is not None


def test_bad_input_is_refused() -> None:
    for call in (
        lambda: to.point_on_arc("tip", to.placement((0, 0, 0)), radius=0.1, tolerance=0.2),
        lambda: to.point_on_arc("tip", to.placement((0, 0, 0)), radius=0.1, tolerance=0.01, sweep=7.0),
    ):
        with pytest.raises(ProblemError):
            call()


def arc(at: World) -> Residual:
    circle = to.placement((0.1, 0.1, 0.2), rpy=(0.1, 0.2, 0.3))
    required = to.point_on_arc("tip", circle, radius=0.2, tolerance=0.01, sweep=2.0, reference="thing")
    return ArcCoordinates(at.reduced, required)


HERE, THREE = to.placement((0.4, 0.1, 0.2)), to.placement((0.5, 0, 0.2))
KIND = Kind(
    requirement=PointOnArc,
    printed=[
        (
            to.point_on_arc("tip", THREE, radius=0.2, tolerance=1e-3),
            "tip on a circle of radius 0.2 m about (0.5, 0, 0.2) m, within 1 mm",
        ),
        (
            to.point_on_arc("tip", THREE, radius=0.05, sweep=np.pi / 2, tolerance=1e-3, reference="tray"),
            "tip on an arc of 90 deg of radius 50 mm about (0.5, 0, 0.2) m from tray, within 1 mm",
        ),
    ],
    relaxed=[to.point_on_arc("tip", HERE, radius=0.2, tolerance=0.02)],
    residuals={ArcCoordinates: [arc]},
    calls={
        "point_on_arc": {
            "frame": "panda_hand_tcp",
            "centre": HERE,
            "radius": 0.2,
            "tolerance": 0.01,
            "sweep": 1.0,
        }
    },
)

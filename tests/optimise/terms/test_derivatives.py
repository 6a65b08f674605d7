"""Every term's Jacobian against finite differences: free, near contact and in penetration."""

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
import trajopt.optimise.terms
from tests.optimise.terms.worlds import KNOTS, World, random_knots, world
from tests.problem.requirements.kind import kinds
from tests.problem.requirements.test_gaze import camera
from trajopt.optimise import terms
from trajopt.optimise.terms.joint_positions import Rolling
from trajopt.optimise.terms.user_functions import Expression
from trajopt.problem.motion import Motion
from trajopt.problem.residual import Residual
from trajopt.values.arrays import Floats, Rows
from trajopt.values.shapes.shapes import Box, Capsule, Cone, Cylinder, Plane, Shape, Sphere, convex

SHAPES: dict[str, Shape] = {
    "box": Box(0.3, 0.3, 0.3),
    "sphere": Sphere(0.15),
    "cylinder": Cylinder(0.15, 0.4),
    "capsule": Capsule(0.1, 0.2),
    "cone": Cone(0.2, 0.4),
    "plane": Plane(),
    "convex": convex(np.random.default_rng(3).normal(size=(20, 3)) * 0.12),
}


def near_pair() -> Residual:
    wished = {
        ("tip", "thing"): terms.SoftDistance(2.5, 30.0),
        ("held", "thing"): terms.SoftDistance(2.0, 0.0),
    }
    return terms.soft_clearance(2.0, weight=7.0, pairs=wished).residual


def height(at: World) -> Callable[[Floats], Floats]:
    def tip(positions: Floats) -> Floats:
        return at.reduced.scene.placement_of("tip", at.reduced.all_positions(positions)).translation

    return tip


FACTORIES: dict[type, Sequence[Callable[[World], Residual]]] = {
    **{term: makers for kind in kinds() for term, makers in kind.residuals.items()},
    terms.Velocity: [lambda _: terms.Velocity()],
    terms.Acceleration: [lambda _: terms.Acceleration()],
    terms.Jerk: [lambda _: terms.Jerk()],
    Expression: [lambda _: Expression("tip", lambda k: k.point("tip", (0.1, 0.0, 0.2), "slide"))],
    Rolling: [lambda _: Rolling((2, 0, 3))],
    terms.RestPosture: [lambda _: terms.RestPosture({"elbow": 0.3, "pan": -0.2})],
    terms.LostManipulability: [lambda _: terms.LostManipulability("finger", 0.01, 0.2)],
    terms.FunctionResidual: [
        lambda at: terms.residual_from_function("tip", height(at)),
        lambda _: terms.residual_from_function(
            "squares", lambda q: q**2, jacobian=lambda q: np.diag(2.0 * q)
        ),
    ],
    terms.Exceeded: [lambda _: terms.Exceeded(camera("world"))],
    terms.SoftClearance: [lambda _: near_pair()],
    terms.Clearance: [lambda at: terms.Clearance(at.reduced, activation=2.0)],
}
"""What makes a term of each class; those of requirements are beside their own tests."""


def every_term() -> list[type]:
    found: set[type] = set()
    for module in pkgutil.walk_packages(trajopt.optimise.terms.__path__, "trajopt.optimise.terms."):
        for _, value in inspect.getmembers(importlib.import_module(module.name), inspect.isclass):
            if (
                value.__module__.startswith("trajopt.optimise.terms")
                and hasattr(value, "linearise")
                and value is not Residual
            ):
                found.add(value)
    return sorted(found, key=lambda cls: cls.__name__)


def keyed(rows: Rows) -> dict[tuple[int, float], int]:
    return {
        (int(c), round(float(p), 6)): i
        for i, (c, p) in enumerate(zip(rows.component, rows.place, strict=True))
    }


def check(
    residual: Residual, at: World, knots: Floats, rng: np.random.Generator, loose: float
) -> tuple[int, int]:
    """Compare directional derivatives; return how many rows were compared and how many are off."""
    rows = residual.linearise(at.motion(knots))
    assert np.isfinite(rows.jacobian).all()
    compared = off = 0
    step = 1e-5
    for _ in range(3):
        direction = rng.normal(size=knots.shape)
        predicted = np.einsum("mkn,mkn->m", rows.jacobian, direction[rows.knots])
        plus = residual.linearise(at.motion(knots + step * direction))
        minus = residual.linearise(at.motion(knots - step * direction))
        high, low = keyed(plus), keyed(minus)
        for key, row in keyed(rows).items():
            if key in high and key in low:
                numeric = (plus.value[high[key]] - minus.value[low[key]]) / (2 * step)
                compared += 1
                off += abs(numeric - predicted[row]) > loose * (1.0 + abs(numeric))
    return compared, off


@pytest.mark.parametrize("term", every_term(), ids=lambda cls: cls.__name__)
def test_jacobian(term: type, tmp_path: Path) -> None:
    assert term in FACTORIES, f"{term.__name__} has no factory in this test"
    at = world(tmp_path, Sphere(0.15), to.placement((0.5, 0.1, 0.3)))
    rng = np.random.default_rng(5)
    for build in FACTORIES[term]:
        residual = build(at)
        for _ in range(4):
            compared, off = check(residual, at, random_knots(at, rng), rng, 1e-4)
            assert compared > 0
            # At a change of the nearest features the distance has a kink, and no derivative.
            assert off <= (0.01 * compared if term in (terms.Clearance, terms.SoftClearance) else 0)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("depth", ["free", "near", "penetrating"])
def test_clearance_jacobian(shape: str, depth: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    at = world(tmp_path, SHAPES[shape], to.placement((0.55, 0.1, 0.25), rpy=(0.3, 0.5, 0.2)))
    wanted = {"free": (0.05, 1.0), "near": (0.0, 0.05), "penetrating": (-0.3, -1e-3)}[depth]
    compared = off = 0
    for _ in range(60):
        knots = np.repeat(random_knots(at, rng)[:1], KNOTS, axis=0) + 1e-3 * rng.normal(size=(KNOTS, 4))
        residual = terms.Clearance(at.reduced, activation=2.0)
        value = residual.linearise(at.motion(knots)).value + at.reduced.scene.margin
        if ((value > wanted[0]) & (value < wanted[1])).any():
            more, wrong = check(residual, at, knots, rng, 1e-3)
            compared, off = compared + more, off + wrong
        if compared > 400:
            break
    assert compared > 50, f"no {depth} configuration was met"
    assert off <= 0.02 * compared


def test_clearance_sign_against_closed_form(tmp_path: Path) -> None:
    """Ball against ball: distance and slope by hand, apart and in penetration."""
    at = world(tmp_path, Sphere(0.1), to.placement((0.7, 0.0, 0.3)))
    rng = np.random.default_rng(2)
    pairs, bodies = at.reduced.pairs, at.reduced.bodies
    names = [{bodies[a].owner, bodies[b].owner} for a, b in zip(pairs.first, pairs.second, strict=True)]
    pair = names.index({"tip", "thing"})
    seen = {True: 0, False: 0}
    for _ in range(1500):
        positions = random_knots(at, rng)[0]
        motion = Motion.single(positions, at.query)
        tip = at.reduced.scene.placement_of("tip", at.reduced.all_positions(positions))
        expected = float(np.linalg.norm(tip * np.array([0.06, 0, 0]) - [0.7, 0.0, 0.3])) - 0.14
        if expected > 0.3:
            continue
        rows = terms.Clearance(at.reduced, activation=0.5).linearise(motion)
        value = rows.value[list(rows.component).index(pair)] + at.reduced.scene.margin
        assert value == pytest.approx(expected, abs=1e-7)
        seen[expected < 0.0] += 1
    assert min(seen.values()) > 3

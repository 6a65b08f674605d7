"""Contact that is meant: accepted in its window and to its depth, and nowhere else."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.judge_search import floor
from tests.verify.arms import joint, link, quintic, reduced, robot
from trajopt.robot.bodies import MeshPolicy
from trajopt.scene.clearances import ContactAllowance
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.scene import Scene
from trajopt.values.placement import placement
from trajopt.values.shapes.mesh import Mesh
from trajopt.values.shapes.shapes import Box, Plane, Shape, convex
from trajopt.verify import Certificate, Check, Evidence, Moment, examine, verify
from trajopt.verify.kernel.clearance_search import Windows

SUNK = 0.0004
"""How deep the part stands in the table at the start [m]."""


def lift(
    folder: Path, *, first: float, last: float = 0.0, depth: float = 1e-3, table: Shape | None = None
) -> ReducedModel:
    """A part held by a vertical slide, standing slightly sunk in a table."""
    slide = robot(
        folder, link("base"), link("hand"), joint("z", "base", "hand", kind="prismatic", axis="0 0 1")
    )
    scene = Scene(slide).add("part", Box(0.1, 0.1, 0.1), frame="hand", touch_links=["hand"])
    top = -0.05 + SUNK
    if table is None:
        scene = scene.add("table", Box(1.0, 1.0, 0.1), placement((0, 0, top - 0.05)))
    else:
        scene = scene.add("table", table, placement((0, 0, top)), meshes=MeshPolicy(exact=True))
    scene = scene.allow_contact("lift off", "part", "table", depth=depth, first=first, last=last)
    return reduced(scene, [0.0])


def lifted(model: ReducedModel, knots: list[float], duration: float = 1.0) -> Certificate:
    return verify(model, quintic(model, [[z] for z in knots], duration), goals=())


def named(certificate: Certificate, name: str) -> Check:
    return next(check for check in certificate.checks if check.name == name)


@pytest.fixture(params=["box", "plane", "exact mesh"])
def table(request: pytest.FixtureRequest) -> Shape | None:
    corners = convex([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.1, 0.0)])
    return {"box": None, "plane": Plane(), "exact mesh": Mesh(corners.vertices, corners.faces)}[request.param]


def test_lifting_off_within_the_window(tmp_path: Path, table: Shape | None) -> None:
    # A minimum-jerk motion of 0.2 m in 1 s leaves the table after some 60 ms.
    model = lift(tmp_path, first=0.3, table=table)
    certificate = lifted(model, [0.0, 0.2])
    assert certificate.verified, str(certificate)
    contact = named(certificate, "contact: lift off")
    assert contact.value == pytest.approx(SUNK, abs=5e-6)
    assert contact.evidence is Evidence.PROVEN
    assert contact.time == 0.0
    # Outside the window the clearance is that at its edge.
    edge = quintic(model, [[0.0], [0.2]], 1.0)(0.3)[0] - SUNK
    assert edge - 1e-3 <= certificate.clearance <= edge
    assert any("lift off" in note for note in certificate.notes)


def test_still_in_contact_when_the_window_closes(tmp_path: Path, table: Shape | None) -> None:
    certificate = lifted(lift(tmp_path, first=0.02, table=table), [0.0, 0.2])
    assert not certificate.verified
    check = named(certificate, "clearance")
    assert check.time is not None
    assert 0.02 <= check.time < 0.1
    assert all(not check.name.startswith("contact") for check in certificate.checks)


def test_deeper_than_accepted(tmp_path: Path, table: Shape | None) -> None:
    certificate = lifted(lift(tmp_path, first=0.5, table=table), [0.0, -0.002, 0.2])
    assert not certificate.verified
    contact = named(certificate, "contact: lift off")
    assert not contact.holds
    assert contact.value == pytest.approx(SUNK + 0.002, abs=2e-4)
    assert contact.time == pytest.approx(0.5, abs=0.05)


def test_setting_down_in_the_last_seconds(tmp_path: Path, table: Shape | None) -> None:
    model = lift(tmp_path, first=0.3, last=0.3, table=table)
    assert lifted(model, [0.0, 0.2, 0.0], 2.0).verified
    model = lift(tmp_path, first=0.3, table=table)
    late = lifted(model, [0.0, 0.2, 0.0], 2.0)
    assert not late.verified
    assert named(late, "clearance").time == pytest.approx(2.0, abs=0.1)


def test_touching_in_the_middle_is_not_excused(tmp_path: Path) -> None:
    model = lift(tmp_path, first=0.3, last=0.3)
    certificate = lifted(model, [0.0, 0.2, 0.0, 0.2, 0.0], 4.0)
    assert not certificate.verified
    assert named(certificate, "clearance").time == pytest.approx(2.0, abs=0.1)


def test_a_window_longer_than_the_motion(tmp_path: Path) -> None:
    certificate = lifted(lift(tmp_path, first=9.0), [0.0, 0.2])
    assert certificate.verified
    assert certificate.clearance == np.inf


def test_windows_lie_on_the_edges_they_name(tmp_path: Path) -> None:
    pairs = lift(tmp_path, first=0.3, last=0.2).pairs
    windows = Windows(pairs, pairs.required, 1.0)
    assert windows.edges.tolist() == [0.3, 0.8]
    times = np.array((0.0, 0.3, 0.3000001, 0.7999, 0.8, 1.0))
    pair = np.full(6, pairs.allowances[0][0])
    assert windows.accept(times, pair).tolist() == [True, True, False, False, True, True]
    assert floor(windows, times, pair).tolist() == [-1e-3, -1e-3, 0.0, 0.0, -1e-3, -1e-3]


def test_two_allowances_of_one_pair(tmp_path: Path) -> None:
    pairs = lift(tmp_path, first=0.3).pairs
    number, allowance = pairs.allowances[0]
    landing = ContactAllowance("land", allowance.a, allowance.b, 2e-3, 0.0, 0.2)
    both = replace(pairs, allowances=((number, allowance), (number, landing)))
    windows = Windows(both, both.required, 1.0)
    times, pair = np.array((0.1, 0.5, 0.9)), np.full(3, number)
    assert floor(windows, times, pair).tolist() == [-1e-3, 0.0, -2e-3]


def test_examining_a_start_knows_the_allowance(tmp_path: Path) -> None:
    model = lift(tmp_path, first=0.3)
    assert examine(model, np.zeros(1), moment=Moment.START).clear
    for moment in (Moment.BETWEEN, Moment.END):
        (pair,) = examine(model, np.zeros(1), moment=moment).collisions
        assert (pair.first, pair.second) == ("part", "table")
        assert pair.distance == pytest.approx(-SUNK, abs=2e-6)
    assert not examine(model, np.array([-0.002]), moment=Moment.START).clear

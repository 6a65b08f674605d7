"""Lists, tuples and tensors in place of arrays."""

from collections.abc import Callable

import numpy as np
import pytest

import trajopt as to
from trajopt.driving import IdealExecutor, SimulatedExecutor
from trajopt.simulation import CameraView
from trajopt.values.arrays import Floats


class Tensor:
    """An array of another library."""

    def __init__(self, entries: object) -> None:
        self._entries = np.asarray(entries, dtype=np.float32)

    def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
        del dtype, copy
        return self._entries


FORMS: dict[str, Callable[[Floats], object]] = {
    "list": lambda array: array.tolist(),
    "tuple": lambda array: tuple(array.tolist()),
    "tensor": Tensor,
}
Given = Callable[[object], Floats]


@pytest.fixture(params=FORMS)
def given(request: pytest.FixtureRequest) -> Given:
    form = FORMS[request.param]
    return lambda entries: form(np.asarray(entries, dtype=np.float64))  # type: ignore[return-value]


@pytest.fixture(scope="module")
def scene() -> to.Scene:
    return to.Scene(to.load("planar2")).add("box", to.Box(0.1, 0.1, 0.1), to.placement((3.0, 0.0, 0.0)))


def test_states_configurations(given: Given, scene: to.Scene) -> None:
    problem = to.Problem(scene=scene, start=given((0.1, 0.2)), goal=given((0.5, 0.6)))
    assert problem.start == pytest.approx((0.1, 0.2))
    assert problem.goal[0].joints == ("joint1", "joint2")
    held = scene.attach("box", "tool", at=given((0.1, 0.2)))
    assert held.object("box").frame == "tool"


def test_states_a_matrix_among_other_goals(scene: to.Scene) -> None:
    matrix = Tensor(to.placement((1.0, 0.5, 0.0)).homogeneous)
    goal = [matrix, to.joint_positions({"joint1": 0.1})]
    assert len(to.Problem(scene=scene, start=(0.0, 0.0), goal=goal).goal) == 2


def test_makes_motions(given: Given) -> None:
    names, rows = ("joint1", "joint2"), given(((0.0, 0.0), (1.0, 1.0)))
    assert to.Path(names, rows).knots.shape == (2, 2)
    motion = to.Trajectory(names, given((0.0, 1.0)), rows, rows, rows)
    assert motion(np.array((1.0,))) == pytest.approx(np.ones((1, 2)))


def test_drives_robots(given: Given, scene: to.Scene) -> None:
    at = given((0.1, 0.2))
    assert IdealExecutor(("joint1", "joint2"), at).state().positions == pytest.approx((0.1, 0.2))
    simulated = SimulatedExecutor(scene, at, tolerance=given((0.01, 0.02)))
    assert simulated.tolerance == pytest.approx((0.01, 0.02))


def test_places_a_camera(given: Given) -> None:
    assert CameraView(given((0.0, 0.0, 1.0)), 1.0, 0.0, 0.0).position == pytest.approx((-1.0, 0.0, 1.0))


def test_refuses_other_entries_by_name() -> None:
    with pytest.raises(to.errors.ShapeError, match="target: must be numbers, is \\['a'\\]"):
        CameraView(["a"], 1.0, 0.0, 0.0)  # type: ignore[arg-type]

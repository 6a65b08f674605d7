"""The robot made of two Pandas is two Pandas."""

import numpy as np
import pytest

import trajopt as to


@pytest.fixture(scope="module")
def both() -> to.Robot:
    try:
        return to.load("two_pandas")
    except to.MissingExtra as error:
        pytest.skip(str(error))


def test_everything_is_there_twice(both: to.Robot) -> None:
    one = to.load("panda")
    assert set(both.joint_names) == {
        f"{side}_{name}" for side in ("left", "right") for name in one.joint_names
    }
    assert set(both.group("both").joints) == set(both.joint_names) - {
        name for name in both.joint_names if "finger" in name
    }
    assert len(both.bodies) == 2 * len(one.bodies)
    assert len(both.disabled_pairs) >= 2 * len(one.disabled_pairs)
    fixed = {"base", "left_panda_link0", "right_panda_link0"}
    for pair in both.disabled_pairs - {pair for pair in both.disabled_pairs if pair <= fixed}:
        assert len({name.split("_")[0] for name in pair - fixed}) <= 1, pair


def test_limits_are_those_of_one(both: to.Robot) -> None:
    one = to.load("panda")
    for side in ("left", "right"):
        place = both.index(f"{side}_{name}" for name in one.joint_names)
        for kind in ("lower", "upper", "velocity", "acceleration", "jerk", "effort"):
            np.testing.assert_array_equal(
                getattr(both.limits, kind)[place], getattr(one.limits, kind), err_msg=kind
            )


@pytest.mark.parametrize(("side", "y"), [("left", 0.4), ("right", -0.4)])
def test_each_hand_is_where_one_pandas_is(both: to.Robot, side: str, y: float) -> None:
    one = to.load("panda")
    rng = np.random.default_rng(0)
    joints = dict(zip(one.joint_names, rng.uniform(one.limits.lower, one.limits.upper).tolist(), strict=True))
    single = to.Scene(one).placement_of("panda_hand_tcp", one.positions(joints))
    double = to.Scene(both).placement_of(
        f"{side}_panda_hand_tcp", both.positions({f"{side}_{name}": value for name, value in joints.items()})
    )
    np.testing.assert_allclose(double.rotation, single.rotation, atol=1e-12)
    np.testing.assert_allclose(double.translation, single.translation + np.array((0.0, y, 0.0)), atol=1e-12)


def test_the_ready_state_covers_both_arms(both: to.Robot) -> None:
    assert both.state("ready", group="both").keys() == set(both.group("both").joints)

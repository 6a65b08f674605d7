"""Forward kinematics and Jacobians against pinocchio's own on the whole robot, and finite differences."""

import numpy as np
import pinocchio as pin
import pytest

import trajopt as to
from trajopt.optimise.kinematics import forward_kinematics, frame_jacobian, manipulability
from trajopt.robot.joints import draw_positions
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats


def drawn(reduced: ReducedModel, count: int = 8) -> Floats:
    return draw_positions(reduced.limits, count, rng=np.random.default_rng(5))


@pytest.mark.parametrize("frame", ["turret", "tip", "finger", "ball", "block", "world"])
@pytest.mark.parametrize("reference", ["world", "fore", "block", "ball"])
def test_placements_are_the_scenes(odd: ReducedModel, frame: str, reference: str) -> None:
    positions = drawn(odd)
    found = forward_kinematics(odd, frame, positions, reference=reference)
    assert len(found) == len(positions)
    for q, where in zip(positions, found, strict=True):
        full = odd.all_positions(q)
        expected = odd.scene.placement_of(reference, full).inverse() * odd.scene.placement_of(frame, full)
        np.testing.assert_allclose(where.homogeneous, expected.homogeneous, atol=1e-12)


def test_one_configuration_is_one_placement(odd: ReducedModel) -> None:
    (only,) = forward_kinematics(odd, "tip", odd.start_positions, offset=(0.1, 0.0, 0.0))
    held = odd.scene.placement_of("tip", odd.start)
    np.testing.assert_allclose(only.translation, held * np.array([0.1, 0.0, 0.0]), atol=1e-12)


def test_jacobian_is_pinocchios(panda: ReducedModel) -> None:
    robot = panda.scene.robot
    data, frame = robot.model.createData(), robot.model.getFrameId("panda_hand_tcp")
    places = robot.index(panda.joint_names)
    positions = drawn(panda)
    for q, ours in zip(positions, frame_jacobian(panda, "panda_hand_tcp", positions), strict=True):
        full = robot.configuration(panda.all_positions(q))
        theirs = pin.computeFrameJacobian(robot.model, data, full, frame, pin.LOCAL_WORLD_ALIGNED)
        np.testing.assert_allclose(ours, theirs[:, places], atol=1e-12)


@pytest.mark.parametrize(("frame", "reference"), [("ball", "world"), ("finger", "slide"), ("ball", "block")])
def test_jacobian_is_the_derivative(odd: ReducedModel, frame: str, reference: str) -> None:
    h, offset = 1e-6, (0.02, -0.01, 0.03)
    positions = drawn(odd)
    jacobian = frame_jacobian(odd, frame, positions, reference=reference, offset=offset)
    here = forward_kinematics(odd, frame, positions, reference=reference)
    for joint in range(positions.shape[1]):
        ahead, behind = (
            forward_kinematics(
                odd, frame, positions + sign * h * np.eye(4)[joint], reference=reference, offset=offset
            )
            for sign in (1.0, -1.0)
        )
        linear = (ahead.translation - behind.translation) / (2 * h)
        spin = (ahead.rotation - behind.rotation) / (2 * h) @ np.swapaxes(here.rotation, 1, 2)
        angular = np.stack((spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]), axis=1)
        np.testing.assert_allclose(jacobian[:, :, joint], np.hstack((linear, angular)), atol=1e-8)


@pytest.mark.parametrize("length", [0.0, 0.3, 1.0])
def test_manipulability_is_the_product_of_singular_values(
    odd: ReducedModel, panda: ReducedModel, length: float
) -> None:
    for reduced, frame in ((odd, "tip"), (panda, "panda_hand")):
        jacobian = frame_jacobian(reduced, frame, drawn(reduced))
        weighed = np.concatenate((jacobian[:, :3], length * jacobian[:, 3:]), axis=1)
        rows = weighed[:, :3] if length == 0.0 else weighed
        expected = np.linalg.svd(rows, compute_uv=False).prod(axis=1)
        np.testing.assert_allclose(manipulability(jacobian, length=length), expected, atol=1e-9)


def test_misuse_is_named(odd: ReducedModel) -> None:
    with pytest.raises(to.TrajoptError, match="no frame named 'tpi'; did you mean 'tip'"):
        forward_kinematics(odd, "tpi", odd.start_positions)
    with pytest.raises(to.TrajoptError, match=r"positions: needs shape \(any, 4\), has \(1, 3\)"):
        frame_jacobian(odd, "tip", [0.0, 0.1, 0.2])

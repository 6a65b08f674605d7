"""Forward kinematics: placements and Jacobians of a frame at one configuration or many."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trajopt.geometry import Evaluator, evaluator
from trajopt.optimise.terms.frames import RelativeFrame, relative_frame
from trajopt.problem.motion import Motion
from trajopt.problem.requirements.joints import LENGTH
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value, floats, one_of, readonly
from trajopt.values.errors import ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement


@dataclass(frozen=True, eq=False)
class Placements(Value):
    """Placements of a frame at S configurations; `placements[3]` is one of them.

    Attributes:
        rotation: Shape (S, 3, 3).
        translation: Shape (S, 3) [m].
    """

    rotation: Floats
    translation: Floats

    def __len__(self) -> int:
        return len(self.translation)

    def __getitem__(self, index: int) -> Placement:
        return Placement(readonly(self.rotation[index].copy()), readonly(self.translation[index].copy()))

    def __iter__(self) -> Iterator[Placement]:
        return (self[index] for index in range(len(self)))


@checked
def forward_kinematics(
    reduced: ReducedModel,
    frame: str,
    positions: ArrayLike,
    *,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> Placements:
    """Place a frame at one configuration or many.

    Args:
        frame: Link, tool frame or object, attached or not.
        positions: Of the group's joints, shape (n,) or (S, n) [rad | m].
        reference: "world", link, tool frame or object that the frame is seen from.
        offset: Point of the frame to place, in the frame, shape (3,) [m].

    Returns:
        S placements; one for positions of shape (n,).

    Raises:
        FrameNotFound: If a frame is unknown.
        ShapeError: If there is not one finite position for each joint.
    """
    at = moving_frame(evaluator(reduced), frame, configurations(reduced, positions), reference, offset)
    return Placements(readonly(at.rotation), readonly(at.point))


@checked
def frame_jacobian(
    reduced: ReducedModel,
    frame: str,
    positions: ArrayLike,
    *,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> Floats:
    """Return the Jacobian of a frame at one configuration or many.

    Rows 0 to 2 are the velocity of the frame's point, rows 3 to 5 its angular velocity, both relative to
    the reference and along its axes; columns are the group's joints at unit speed.

    Args:
        positions: Shape (n,) or (S, n) [rad | m].
        reference: "world", link, tool frame or object that the motion is seen from.
        offset: The point, in the frame, shape (3,) [m].

    Returns:
        Shape (S, 6, n) [m/rad | m/m, rad/rad | rad/m]; S is 1 for positions of shape (n,).

    Raises:
        FrameNotFound: If a frame is unknown.
        ShapeError: If there is not one finite position for each joint.
    """
    at = moving_frame(evaluator(reduced), frame, configurations(reduced, positions), reference, offset)
    return stacked_jacobian(at)


def moving_frame(
    query: Evaluator,
    frame: str,
    positions: Floats,
    reference: str = WORLD,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> RelativeFrame:
    """Evaluate a frame and its derivatives with a given query; see `forward_kinematics`."""
    reduced, point = query.reduced, floats("offset", offset, (3,))
    motion = Motion.each(positions, query)
    return relative_frame(reduced, motion, frame_of(reduced, frame), frame_of(reduced, reference), point)


def stacked_jacobian(at: RelativeFrame) -> Floats:
    """Return the Jacobian of an evaluated frame, linear rows over angular ones, shape (S, 6, n)."""
    return np.concatenate((at.point_jacobian, at.angular_jacobian), axis=1)


def manipulability(jacobian: Floats, *, length: float = LENGTH) -> Floats:
    """Return Yoshikawa's manipulability of Jacobians.

    It is the product of the min(6, n) singular values of (J_v, length J_w), which is proportional to the
    volume of the ellipsoid of velocities that joints at unit speed produce; zero at a singularity. Source:
    Yoshikawa, Manipulability of robotic mechanisms, IJRR 1985.

    Args:
        jacobian: Of `frame_jacobian`, shape (S, 6, n).
        length: Length that a radian of rotation counts as [m]; 0 counts the point's motion only.

    Returns:
        Shape (S,) [m^min(6, n) for joints that turn].
    """
    rows = jacobian[:, :3] if length == 0.0 else jacobian * np.repeat((1.0, length), 3)[:, None]
    transposed = np.swapaxes(rows, 1, 2)
    gram = rows @ transposed if rows.shape[1] <= rows.shape[2] else transposed @ rows
    return np.sqrt(np.maximum(np.linalg.det(gram), 0.0))


def configurations(reduced: ReducedModel, positions: ArrayLike) -> Floats:
    joints = len(reduced.joint_names)
    try:
        rows = np.atleast_2d(np.asarray(positions, dtype=np.float64))
    except (TypeError, ValueError) as error:
        raise ShapeError("positions", f"must be numbers, is {shown(positions)}") from error
    return floats("positions", rows, (None, joints))


def frame_of(reduced: ReducedModel, name: str) -> str:
    """Return the name of an existing frame.

    Raises:
        FrameNotFound: If it is not.
        ProblemError: If it is not a name.
    """
    reduced.attachment(one_of("frame", name, str))
    return name

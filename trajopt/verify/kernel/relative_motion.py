"""Frames and points moved by the robot, with bounds on their motion."""

from dataclasses import dataclass

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement
from trajopt.verify.kernel.kinematics import Travel, relative_chain
from trajopt.verify.kernel.motion import JudgedMotion


@dataclass(frozen=True, eq=False)
class RateBounds:
    """Bounds over intervals, each of shape (c,).

    Attributes:
        turn: Angle from the orientation in the middle [rad].
        shift: Distance of the point from its place in the middle [m].
        turn_rate: Angular speed [rad/s].
        turn_acceleration: Angular acceleration [rad/s^2].
        point_rate: Speed of the point [m/s].
        point_acceleration: Acceleration of the point [m/s^2].
    """

    turn: Floats
    shift: Floats
    turn_rate: Floats
    turn_acceleration: Floats
    point_rate: Floats
    point_acceleration: Floats


class RelativeMotion:
    """A frame and a point of it, relative to a reference frame.

    Bounds on rates follow the chain of joints from the frame inwards. With r the largest distance of
    the point from the axis of a joint that turns at rate w and accelerates by a, the point's speed v and
    acceleration u relative to the joint's parent are at most v + w r and u + 2 w v + w^2 r + a r.
    """

    def __init__(self, motion: JudgedMotion, frame: str, *, reference: str, offset: Floats) -> None:
        """Find the joints between the two.

        Args:
            reference: "world", or a link, tool frame or object.
            offset: Point in the frame's coordinates, shape (3,) [m].

        Raises:
            FrameNotFound: If a frame is unknown.
        """
        self._motion = motion
        self._joint, frame_place = motion.reduced.attachment(frame)
        self._base, self._reference = motion.reduced.attachment(reference)
        self._frame = Placement(frame_place.rotation, frame_place * offset)
        chain, _ = relative_chain(motion.kinematics, self._joint, self._base)
        self._chain = chain
        self._travel = Travel(
            motion.kinematics,
            carrier=[self._joint],
            centre=self._frame.translation[None],
            radius=np.zeros(1),
            chains=[chain],
        )

    def placements(self, times: Floats) -> tuple[Floats, Floats]:
        """Return rotation of the frame (c, 3, 3) and position of the point (c, 3) [m] at times (c,)."""
        poses = self._motion.poses(times)
        frame_rotation = poses.rotation[:, self._joint] @ self._frame.rotation
        point = poses.rotation[:, self._joint] @ self._frame.translation
        point = point + poses.translation[:, self._joint]
        base_rotation = poses.rotation[:, self._base] @ self._reference.rotation
        origin = poses.rotation[:, self._base] @ self._reference.translation
        origin = origin + poses.translation[:, self._base]
        inward = np.swapaxes(base_rotation, 1, 2)
        return inward @ frame_rotation, np.einsum("cij,cj->ci", inward, point - origin)

    def bounds(self, begin: Floats, end: Floats) -> RateBounds:
        """Bound the rates over intervals, shape (c,) each [s]."""
        motion = self._motion
        poses = motion.poses((begin + end) / 2)
        moved = motion.deviation(begin, end)
        speed, increase = motion.rates(begin, end, 1), motion.rates(begin, end, 2)
        centres = self._travel.centres(poses)
        bounds = self._travel.bound(poses, centres, moved)
        zero = np.zeros(len(begin))
        turn, rate, turn_acceleration = zero, zero, zero
        velocity, acceleration = zero, zero
        for step, joint in enumerate(self._chain):
            w, a = speed[:, joint], increase[:, joint]
            if not motion.kinematics.revolute[joint]:
                velocity, acceleration = velocity + w, acceleration + a
                continue
            radius = bounds.levers[:, 0, step]
            acceleration = acceleration + 2.0 * w * velocity + (w**2 + a) * radius
            velocity = velocity + w * radius
            turn_acceleration = turn_acceleration + a + rate * w
            rate, turn = rate + w, turn + moved[:, joint]
        shift = bounds.travel[:, 0, -1]
        return RateBounds(turn, shift, rate, turn_acceleration, velocity, acceleration)


@dataclass(frozen=True, eq=False)
class VelocityChanges:
    """Bounds over intervals, each of shape (c, 2): for the point [m] and the frame's rotation [rad].

    Attributes:
        first: Bound of the first derivative of the velocity [m/s^2], [rad/s^2].
        second: Bound of its second derivative [m/s^3], [rad/s^3].
    """

    first: Floats
    second: Floats


class PointMotion:
    """A point of a frame in the world: its velocity, with bounds on higher derivatives.

    Bounds follow the chain of joints from the frame inwards. Let x be the point relative to the parent of a
    joint that turns by the angle t about a fixed axis, S the cross product with the axis, R the turn. Then

        (R x)'''  = R (x''' + 3 t' S x'' + 3 (t'' S + t'^2 S^2) x' + (t''' S + 3 t' t'' S^2 + t'^3 S^3) x),

    and |S x| is the distance r of the point from the axis, |S x'| is at most |x'|. The first two derivatives
    are bounded likewise, as is the angular velocity, to which every joint adds its axis times its rate.
    """

    def __init__(self, motion: JudgedMotion, frame: str, *, offset: Floats) -> None:
        """Find the joints that carry the frame.

        Args:
            offset: Point in the frame's coordinates, shape (3,) [m].
        """
        self._motion = motion
        self._joint, place = motion.reduced.attachment(frame)
        self._point: Floats = place * offset
        self._chain = motion.kinematics.chain(self._joint)
        self._travel = Travel(
            motion.kinematics,
            carrier=[self._joint],
            centre=self._point[None],
            radius=np.zeros(1),
            chains=[self._chain],
        )

    def speeds(self, times: Floats) -> tuple[Floats, Floats]:
        """Return velocities of the point and angular velocities of the frame, (c, 3) each [m/s | rad/s]."""
        motion, kinematics = self._motion, self._motion.kinematics
        poses = motion.poses(times)
        rates = motion.trajectory(times, 1) @ motion.reduced.mimic_matrix.T
        chain = np.array(self._chain, dtype=np.int64)
        axes = np.einsum("cjab,jb->cja", poses.rotation[:, chain], kinematics.axes[chain])
        turning = axes * rates[:, chain - 1, None]
        point = poses.rotation[:, self._joint] @ self._point + poses.translation[:, self._joint]
        arms = point[:, None] - poses.translation[:, chain]
        turns = kinematics.revolute[chain][:, None].astype(np.float64)
        across = np.asarray(np.cross(turning, arms), dtype=np.float64)
        velocity = turns * across + (1.0 - turns) * turning
        return velocity.sum(axis=1), (turns * turning).sum(axis=1)

    def changes(self, begin: Floats, end: Floats) -> VelocityChanges:
        """Bound the derivatives of the velocities, given the start and end of intervals, shape (c,) [s]."""
        motion = self._motion
        poses = motion.poses((begin + end) / 2)
        rates, increases, jerks = (motion.rates(begin, end, order) for order in (1, 2, 3))
        centres = self._travel.centres(poses)
        levers = self._travel.bound(poses, centres, motion.deviation(begin, end)).levers[:, 0]
        zero = np.zeros(len(begin))
        v, u, k = zero, zero, zero  # of the point: velocity, acceleration, jerk
        turn, turn_first, turn_second = zero, zero, zero  # angular velocity and its derivatives
        for step, joint in enumerate(self._chain):
            w, a, j = rates[:, joint], increases[:, joint], jerks[:, joint]
            if not motion.kinematics.revolute[joint]:
                v, u, k = v + w, u + a, k + j
                continue
            r = levers[:, step]
            k = k + 3.0 * w * u + 3.0 * (a + w**2) * v + (j + 3.0 * w * a + w**3) * r
            u = u + 2.0 * w * v + (a + w**2) * r
            v = v + w * r
            turn_second = turn_second + 2.0 * w * turn_first + (a + w**2) * turn + j
            turn_first = turn_first + w * turn + a
            turn = turn + w
        return VelocityChanges(np.stack((u, turn_first), axis=1), np.stack((k, turn_second), axis=1))

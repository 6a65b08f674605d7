"""One frame of a moving robot seen from another, with bounds on how it moves.

Bounds on rates follow the chain of joints from the frame inwards. With r the largest distance of
the point from the axis of a joint that turns at rate w and accelerates by a, the point's speed v and
acceleration u as seen from behind the joint are at most v + w r and u + 2 w v + w^2 r + a r.
"""

from dataclasses import dataclass

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.travel import Travel, relative_chain


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
    """A frame and a point of it, seen from a reference frame."""

    def __init__(self, motion: Motion, frame: str, *, reference: str, offset: Floats) -> None:
        """Find the joints between the two.

        Args:
            motion: The motion.
            frame: Link, tool frame or object.
            reference: "world", or a link, tool frame or object.
            offset: The point, in the frame's coordinates, shape (3,) [m].

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
        """Return rotation of the frame (c, 3, 3) and place of the point (c, 3) [m] at times (c,)."""
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
        """Bound the motion over intervals, given the start and end of each, shape (c,) [s]."""
        motion = self._motion
        poses = motion.poses((begin + end) / 2)
        moved = motion.deviation(begin, end)
        speed, increase = motion.rates(begin, end, 1), motion.rates(begin, end, 2)
        centres = self._travel.centres(poses)
        travel = self._travel.bound(poses, centres, moved)[:, 0]
        zero = np.zeros(len(begin))
        turn, rate, turn_acceleration = zero, zero, zero
        velocity, acceleration = zero, zero
        for step, joint in enumerate(self._chain):
            w, a = speed[:, joint], increase[:, joint]
            if not motion.kinematics.revolute[joint]:
                velocity, acceleration = velocity + w, acceleration + a
                continue
            radius = self._travel.reach(poses, centres, step)[:, 0] + travel[:, step]
            acceleration = acceleration + 2.0 * w * velocity + (w**2 + a) * radius
            velocity = velocity + w * radius
            turn_acceleration = turn_acceleration + a + rate * w
            rate, turn = rate + w, turn + moved[:, joint]
        return RateBounds(turn, travel[:, -1], rate, turn_acceleration, velocity, acceleration)

"""Simulated execution of a motion along a curve, with correction of the error at its end."""

from dataclasses import dataclass

from trajopt.problem.requirements import follows_curve
from trajopt.scene.scene import Scene
from trajopt.simulation import PoseError, Rollout, SimulationOptions, simulate
from trajopt.tasks.cartesian.curves import line
from trajopt.tasks.cartesian.following import FollowOptions, follow
from trajopt.tasks.cartesian.result import Followed
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement

POSITION = 1e-3
"""Default accepted position error at the end [m]."""
ROTATION = 1e-2
"""Default accepted rotation error at the end [rad]."""
MOVES = 3
"""Most correction moves."""


@dataclass(frozen=True, eq=False)
class Executed:
    """An executed motion along a curve, with the moves that corrected its end.

    Attributes:
        rollouts: The simulated motion, then each correction move.
        errors: Error of the frame at the end of each. The last correction may have failed.
    """

    rollouts: tuple[Rollout, ...]
    errors: tuple[PoseError, ...]
    moves: tuple[Followed, ...]
    reached: bool


@checked
def execute(
    followed: Followed,
    *,
    position_tolerance: float = POSITION,
    rotation_tolerance: float = ROTATION,
    options: SimulationOptions | None = None,
) -> Executed:
    """Execute a motion along a curve in simulation, and correct its end if the error is too large.

    A correction move is the straight line from the actual to the required pose.

    Raises:
        ProblemError: Without a verified motion.
    """
    trajectory, required = followed.trajectory, followed.required
    if trajectory is None or not followed.verified:
        raise ProblemError(f"there is no verified motion to execute: {followed.reason}")
    reduced = followed.problem.reduced
    end = _seen(followed, trajectory(trajectory.duration))
    rollouts = [simulate(reduced, trajectory, options=options)]
    errors = [PoseError.between(end, _seen(followed, rollouts[-1].positions[-1]))]
    moves: list[Followed] = []
    limited = FollowOptions(
        velocity_scaling=followed.problem.velocity_scaling,
        acceleration_scaling=followed.problem.acceleration_scaling,
        tool_speed=followed.problem.tool_speeds,
    )
    while len(moves) < MOVES and not _within(errors[-1], position_tolerance, rotation_tolerance):
        reached = rollouts[-1].positions[-1]
        closing = follows_curve(
            required.frame,
            line(_seen(followed, reached), end),
            reference=required.reference,
            offset=required.offset,
            position_tolerance=required.position_tolerance,
            rotation_tolerance=min(required.rotation_tolerance, rotation_tolerance),
        )
        move = follow(
            _later(followed.problem.scene, sum(rollout.duration for rollout in rollouts)),
            closing,
            group=followed.problem.group,
            start=reduced.all_positions(reached),
            options=limited,
        )
        moves.append(move)
        if move.trajectory is None or not move.verified:
            break
        rollouts.append(simulate(move.problem.reduced, move.trajectory, options=options))
        errors.append(PoseError.between(end, _seen(followed, rollouts[-1].positions[-1])))
    held = _within(errors[-1], position_tolerance, rotation_tolerance)
    return Executed(tuple(rollouts), tuple(errors), tuple(moves), held)


def _later(scene: Scene, time: float) -> Scene:
    return scene.at(time) if scene.changing else scene


def _seen(followed: Followed, positions: Floats) -> Placement:
    scene, required = followed.problem.scene, followed.required
    everywhere = followed.problem.reduced.all_positions(positions)
    base = scene.placement_of(required.reference, everywhere)
    point = Placement(translation=required.offset)
    return base.inverse() * (scene.placement_of(required.frame, everywhere) * point)


def _within(error: PoseError, position: float, rotation: float) -> bool:
    return error.position <= position and error.rotation <= rotation

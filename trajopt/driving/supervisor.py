"""Supervisor: drives a robot to goals among what it is told of the world, always able to stop."""

from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.driving.active_motion import ActiveMotion
from trajopt.driving.commit_loop import Commitment, off_track, outside_limits
from trajopt.driving.committed_motion import REST, CommittedMotion
from trajopt.driving.events import Event, EventKind, Journal
from trajopt.driving.executor import Executor
from trajopt.driving.goal_queue import FollowedGoal, GoalNow, GoalQueue
from trajopt.driving.intended_motion import GuardedGoal, IntendedMotion
from trajopt.driving.motion_guard import guard_of
from trajopt.driving.options import SupervisorOptions, on_clock
from trajopt.driving.replanning import recovery
from trajopt.driving.soonest_stop import StopTaken
from trajopt.driving.world_snapshot import WorldSnapshot
from trajopt.planning.moving.meeting import goals_that_move
from trajopt.problem.problem import Problem
from trajopt.problem.stated import GoalLike
from trajopt.scene.group_tools import tool_of
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Printed, function, number
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import IDENTITY, PlacementLike, as_placement
from trajopt.values.shapes.shapes import Points, Voxels

DEFAULT = SupervisorOptions()
SLOW = 1e-2
"""A joint this slow stands, as far as sensors tell [rad/s | m/s]."""


@checked
@dataclass(eq=False)
class Supervisor(Printed):
    """Drives a robot to goals.

    What the executor has to drive is at all times: the motion for a short time ahead, and then a stop along
    its path, proven as one motion in the world as it was known. Each cycle proves the next such motion and
    splices it in where the last one would begin to brake. What is not proven is not spliced in, and then the
    robot stops as it was proven before. So it does where no cycle comes any more.

    Attributes:
        executor: What drives the robot.
        problem: What is required on the way, and the goal.
        options: Numbers to work with.
        events: What happened, in order.
        seconds: CPU time that each stage took, each time [s].
    """

    executor: Executor
    problem: Problem
    options: SupervisorOptions = DEFAULT
    events: list[Event] = field(init=False)
    seconds: dict[str, list[float]] = field(init=False)
    _journal: Journal = field(init=False)
    _commitment: Commitment = field(init=False)
    _running: ActiveMotion = field(init=False)
    _agenda: GoalQueue = field(init=False)
    _revise: bool = field(default=False, init=False)
    _measured: dict[str, float] = field(default_factory=dict[str, float], init=False)

    def __post_init__(self) -> None:
        """Take the robot as it stands."""
        executor, state, now = self.executor, self.executor.state(), self.executor.now()
        if np.abs(state.velocities).max() > REST:
            raise ProblemError("the robot moves: a supervisor takes it over where it stands")
        self._journal = Journal(executor.now)
        self.events, self.seconds = self._journal.events, self._journal.seconds
        guard = guard_of(self.problem, executor)
        if outside := outside_limits(guard.problem, executor):
            self._journal.note(EventKind.OUTSIDE_LIMITS, outside)
        self._commitment = Commitment(
            executor,
            self._journal,
            guard,
            WorldSnapshot(self.problem.scene, now),
            CommittedMotion(executor.joint_names, state.commanded),
        )
        self._running = ActiveMotion(self._commitment, self.options, None, now)
        self._agenda = GoalQueue(self._commitment, self._running, self.options)

    @property
    def scene(self) -> Scene:
        """The world as it was last told."""
        return self._commitment.world.scene

    @property
    def seen(self) -> WorldSnapshot:
        """The world as it was last told, and when."""
        return self._commitment.world

    @property
    def committed(self) -> CommittedMotion:
        """What the robot will do whatever comes; not to be changed."""
        return self._commitment.motion

    @property
    def intended(self) -> IntendedMotion | None:
        """The motion to the goal that it is on; None while there is none."""
        return self._running.intended

    @property
    def moving(self) -> bool:
        """Whether the robot has to move now, or will have to."""
        return self.executor.now() < self._commitment.motion.end

    @property
    def busy(self) -> bool:
        """Whether there is a goal that is not reached."""
        return self._agenda.open or self.moving

    @property
    def blocked(self) -> bool:
        """Whether the robot stands, and there is no plan to the goal in the world as it is known."""
        return self._agenda.given_up and not self.moving

    @checked
    def go(self, problem: Problem, *, blend_radius: float = 0.0) -> None:
        """Go to a goal, in place of all others; the next cycle plans there, from where the robot is then.

        Args:
            problem: Its start, the scene and the name of the group are those of the supervisor.
            blend_radius: If another goal comes after it (`then`), the robot need not stop at this one: it
                is enough that the tool passes within so much of where it would be at the goal [m].

        Raises:
            ProblemError: If it is of another group or robot, its goal moves, or the radius is negative.
        """
        goal = self._goal(problem, blend_radius)
        if self._running.intended is not None:
            self._journal.note(EventKind.GOAL_CHANGED)
        self.problem = problem
        self._agenda.go(goal)

    @checked
    def then(self, problem: Problem, *, blend_radius: float = 0.0) -> None:
        """Go to a goal after all others; the motion there is planned while the one before is driven.

        It begins at rest at the goal before; where that has a blend radius, on the way, so near to it, if it
        is over sooner then. If there is no motion to it, the robot stands at the goal before.

        Args:
            problem: As of `go`.
            blend_radius: As of `go`.

        Raises:
            ProblemError: As of `go`.
        """
        self._agenda.then(self._goal(problem, blend_radius))

    @checked
    def follow_goal(
        self,
        goal: str | GoalNow,
        *,
        offset: PlacementLike = IDENTITY,
        tool: str = "",
        tolerance: float = 2e-3,
        hold: float = 0.0,
    ) -> None:
        """Go to a goal that moves, in place of all others: the motion is planned anew while it is driven.

        Each cycle asks where the goal is. Where it moves on a track that is known, that is where it is at the
        end of the motion. The robot comes to rest at the goal; if it has moved then, it goes on. The rest
        is required as of the supervisor's problem.

        Args:
            goal: A frame of the scene, as `see` told it last, which the group's tool goes to; or a function
                that returns the goal as it is now, in any form that a problem takes, or None where it does
                not know.
            offset: Where the tool goes as seen from the frame.
            tool: Which frame of the robot goes there; the group's own tool when empty.
            tolerance: By how much more than its own tolerances the goal may be missed at the end of the
                motion before that is planned anew [m | rad].
            hold: The goal is reached when it has held for so long while the robot stands [s]; with infinity
                it is followed until something else is asked for.

        Raises:
            FrameNotFound: If there is no such frame.
            ProblemError: If the tolerance is not positive, the time is negative, or `goal` is neither.
        """
        if number("tolerance", tolerance) <= 0.0 or number("hold", hold, infinite=True) < 0.0:
            raise ProblemError(
                f"tolerance must be positive, is {tolerance:g}; hold not negative, is {hold:g}"
            )
        scene, where = self.scene, as_placement("offset", offset)
        if isinstance(goal, str):
            scene.holder(goal)
            tool = tool or tool_of(scene, self.problem.group)
            scene.holder(tool)
        else:
            function("goal", goal)
        followed = self._goal(self.problem, 0.0)
        self._agenda.follow(FollowedGoal(followed, goal, where, tool, tolerance, hold))

    @checked
    def see(self, scene: Scene, stamp: float | None = None) -> None:
        """Tell it what the world is like; the next cycle judges by it what is left of the motion.

        Args:
            scene: Its clock shows 0 at the time of the stamp.
            stamp: On the executor's clock [s]; now when None.

        Raises:
            ClockError: If the stamp is ahead of the executor's clock by more than `clock_tolerance`.
            ProblemError: If it is a scene of another robot. Nothing is changed in either case.
        """
        commitment = self._commitment
        commitment.world = commitment.world.followed_by(scene, self._on_clock(stamp))
        self._revise = True
        self._journal.note(EventKind.WORLD_CHANGED)

    @checked
    def see_cloud(self, name: str, cloud: Points | Voxels | None, stamp: float | None = None) -> bool:
        """Tell it what a camera sees, in place of all that it saw before; else the world stays as told.

        Images that overtake each other on their way do no harm: what is older than the newest is left out.

        Args:
            name: Of the cloud in the scene.
            cloud: In the world; None where nothing is seen.
            stamp: When it was measured, on the executor's clock [s]; now when None.

        Returns:
            Whether it is newer than what it takes the place of.

        Raises:
            ClockError: If the stamp is ahead of the executor's clock by more than `clock_tolerance`; images
                that come after it, with right stamps, still count.
            ModelError: If the name is one of the robot's, or of an object that is no cloud.
        """
        measured = self._on_clock(stamp)
        if measured < self._measured.get(name, -np.inf):
            return False
        world = self._commitment.world
        self.see(world.scene.with_cloud(name, cloud), world.stamp)
        self._measured[name] = measured
        return True

    def cycle(self) -> None:
        """Watch the robot, prove what comes next, and plan anew where that is needed."""
        with self._journal.stage("cycle"):
            if self._failed():
                return
            if self._revise:
                self._revise = False
                with self._journal.stage("look again"):
                    self._look_again()
            self._agenda.work(self.executor.now())

    def stop(self) -> StopTaken:
        """Bring the robot to rest as soon as that is proven to be clear of everything.

        Of a stop along the path and one in which each joint brakes as hard as it may, the sooner one that is
        proven is taken; if none is, the sooner one. There are no goals any more.
        """
        with self._journal.stage("stop"):
            taken = self._running.stop(self.problem, "asked for")
        self._agenda.abandon()
        return taken

    @checked
    def recover(self, goal: GoalLike, *, scaling: float = 0.1) -> bool:
        """Bring the robot out of a fault, and of light contact, and on to a goal, slowly.

        The fault is cleared. The whole motion is judged and committed at once: out of what touches, which
        separates all the time, then clear of everything. What it is, is in the events.

        Args:
            goal: Where to go, as of a problem: "ready".
            scaling: Factor in (0, 1] on the limits of velocity and acceleration.

        Returns:
            Whether there is such a motion; if not, the robot stands, and the events say why.

        Raises:
            ProblemError: If the robot moves, or the scaling is no such factor; the fault stays then.
        """
        if self.moving and np.abs(self.executor.state().velocities).max() > SLOW:
            raise ProblemError("the robot moves: it recovers where it stands")
        # What is no goal or no scaling is refused by this, before the fault is cleared.
        replace(self.problem, goal=goal, velocity_scaling=scaling, acceleration_scaling=scaling)
        self.executor.clear_fault()
        commitment = self._commitment
        self._agenda.abandon()
        commitment.stand()
        at = self.executor.now() + self.options.ahead
        if commitment.stale(at):
            return False
        here = commitment.still_at(self.problem, at, commitment.world.at(at))
        found = recovery(here, here.scene, here.start_positions, goal, scaling=scaling)
        if found.trajectory is None:
            self._journal.note(EventKind.NO_PLAN, found.words)
            return False
        commitment.held = False  # constraints do not count
        self._journal.note(EventKind.RECOVERING, found.words)
        return commitment.splice(found.trajectory, max(at, commitment.soonest))

    def _on_clock(self, stamp: float | None) -> float:
        return on_clock(stamp, self.executor.now(), self.options.clock_tolerance)

    def _look_again(self) -> None:
        """Judge what is committed, and what is left of the motion, in the world as it is known now."""
        commitment = self._commitment
        begin = commitment.soonest
        committed = commitment.motion.ahead(begin, commitment.joint_names)
        if committed is not None and not commitment.proven(committed, begin):
            self._agenda.interrupted()
            with self._journal.stage("stop"):
                self._running.stop(self.problem, "what it was to do is not clear any more")
        self._agenda.look_again()

    def _failed(self) -> bool:
        """Whether the robot does not follow; if it is not where it has to be, it is stopped."""
        fault, agenda = self.executor.fault(), self._agenda
        if fault:
            if agenda.open:
                self._journal.note(EventKind.FAULT, fault)
        else:
            words = off_track(self.executor, self._commitment.motion, self.problem.scene.robot)
            if not words:
                return False
            self._journal.note(EventKind.OFF_TRACK, words)
            self.executor.stop()
        agenda.abandon()
        return True

    def _goal(self, problem: Problem, blend_radius: float) -> GuardedGoal:
        """Return a goal of the same group of the same robot.

        Raises:
            ProblemError: If it is of another, its goal moves, or the radius is negative, or positive and
                the group has no single tool.
        """
        own = self.problem
        if problem is not own and (problem.group != own.group or problem.scene.robot is not own.scene.robot):
            raise ProblemError("a supervisor drives one group of one robot: make another one")
        if number("blend_radius", blend_radius) > 0.0:
            tool_of(problem.scene, problem.group)
        if blend_radius < 0.0:
            raise ProblemError(f"blend_radius must not be negative, is {blend_radius:g} m")
        if moving := goals_that_move(problem):
            raise ProblemError(f"the goal moves with {', '.join(sorted(moving))}: use follow_goal")
        return GuardedGoal(problem, guard_of(problem, self.executor), blend_radius)

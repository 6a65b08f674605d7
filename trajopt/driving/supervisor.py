"""A supervisor drives a robot to goals among reported obstacles, able to stop at all times."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from trajopt.driving.active_motion import ActiveMotion
from trajopt.driving.commit_loop import CommitLoop
from trajopt.driving.events import EventKind
from trajopt.driving.executor import GripperDriver
from trajopt.driving.goal_queue import FollowedGoal, GoalNow, GoalQueue
from trajopt.driving.intended_motion import GuardedGoal, IntendedMotion
from trajopt.driving.motion_guard import guard_of
from trajopt.driving.options import SupervisorOptions
from trajopt.driving.replanning import recovery
from trajopt.driving.soonest_stop import StopTaken
from trajopt.planning.moving.rendezvous import goals_that_move
from trajopt.problem.problem import Problem
from trajopt.problem.stated import GoalLike
from trajopt.scene.group_tools import tool_of
from trajopt.scene.scene import Scene
from trajopt.values.arrays import function, not_negative, number, one_of
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked_class
from trajopt.values.placement import IDENTITY, PlacementLike, as_placement

if TYPE_CHECKING:
    from trajopt.driving.driven_task import DrivenTask
    from trajopt.tasks.task import Task

DEFAULT = SupervisorOptions()
SLOW = 1e-2


@checked_class
@dataclass(eq=False)
class Supervisor(CommitLoop):
    """Drives a robot to goals.

    The executor always holds a short piece of the motion and a stop along its path, proven as one motion.
    Each cycle splices in the next one before the last one brakes.
    """

    options: SupervisorOptions = DEFAULT
    gripper: GripperDriver | None = None
    _active: ActiveMotion = field(init=False)
    _goals: GoalQueue = field(init=False)
    _task: "DrivenTask | None" = field(init=False, default=None)

    def __post_init__(self) -> None:
        ahead, latency = self.options.ahead, self.executor.latency
        if ahead <= latency:
            raise ProblemError(
                f"ahead must be longer than the latency of the executor, {latency:g} s, is {ahead:g} s"
            )
        super().__post_init__()
        self._active = ActiveMotion(self._commitment, self.options)
        self._goals = GoalQueue(self._commitment, self._active, self.options)

    @property
    def seconds(self) -> dict[str, list[float]]:
        return self._commitment.journal.seconds

    @property
    def intended(self) -> IntendedMotion | None:
        return self._active.intended

    @property
    def busy(self) -> bool:
        return self._engaged or self.moving

    @property
    def blocked(self) -> bool:
        """Whether the robot is at rest and there is no plan to the goal in the world as last reported."""
        given_up = self._goals.given_up if self._task is None else self._task.given_up
        return given_up and not self.moving

    def go(self, problem: "Problem | Task", *, blend_radius: float = 0.0) -> None:
        """Go to a goal, or do a task, instead of all others; the next cycle plans from the present state.

        A task is planned at rest, and its remaining stages again if necessary
        (docs/execution.md#a-whole-task). Its last event is `COMPLETED`.

        Args:
            problem: Has the group and robot of the supervisor; its start and scene do not count.
            blend_radius: If another goal follows (`then`), the tool may pass within this distance of its
                position at the goal instead of stopping there [m].

        Raises:
            ProblemError: If the group or robot is another one, the goal moves, or the radius is negative; or
                if a task moves fingers without a driver, or has a radius.
        """
        if not isinstance(problem, Problem):
            self._go(problem, blend_radius)
            return
        goal = self._goal(problem, blend_radius)
        self._drop_task()
        if self._active.intended is not None:
            self._commitment.journal.note(EventKind.GOAL_CHANGED)
        self.problem = problem
        self._goals.go(goal)

    def then(self, problem: Problem, *, blend_radius: float = 0.0) -> None:
        """Go to a goal after all others; the motion to it is planned while the one before is driven.

        Arguments and errors as for `go`.
        """
        if self._task is not None:
            raise ProblemError("a task is driven: add the goal to its stages (MoveTo)")
        self._goals.then(self._goal(problem, blend_radius))

    def follow_goal(
        self,
        goal: str | GoalNow,
        *,
        offset: PlacementLike = IDENTITY,
        tool: str = "",
        tolerance: float = 2e-3,
        hold: float = 0.0,
    ) -> None:
        """Go to a moving goal instead of all others; the motion is replanned while it is driven.

        Each cycle determines the goal, by the track of its frame at the end of the motion if there is one.
        The supervisor's problem has the other requirements.

        Args:
            goal: A frame of the scene as last reported, to which the tool goes; or a function that returns
                the present goal, in any form that a problem accepts, or None if it is not known.
            offset: Placement of the tool in the frame.
            tool: Frame of the robot that goes there; the tool of the group if empty.
            tolerance: Additional error of the goal at the end of the motion above which it is replanned
                [m | rad].
            hold: The goal is reached when it has held for this time while the robot is at rest [s]; with
                infinity it is followed until another command.

        Raises:
            FrameNotFound: If the frame does not exist; also by `see`, for a world without it.
            ProblemError: If the tolerance is not positive, the time is negative, or `goal` is neither.
        """
        if number("tolerance", tolerance) <= 0.0 or number("hold", hold, infinite=True) < 0.0:
            raise ProblemError(
                f"tolerance must be positive, is {tolerance:g}; hold must not be negative, is {hold:g}"
            )
        scene, placed = self.scene, as_placement("offset", offset)
        if isinstance(goal, str):
            scene.holder(goal)
            tool = tool or tool_of(scene, self.problem.group)
            scene.holder(tool)
        else:
            function("goal", goal)
        followed = self._goal(self.problem, 0.0)
        self._drop_task()
        self._goals.follow(FollowedGoal(followed, goal, placed, tool, tolerance, hold))

    def cycle(self) -> None:
        """Watch the robot, prove the next piece of the motion, and replan if necessary."""
        with self._commitment.journal.stage("cycle"):
            if self._watch():
                self._goals.advance(self.executor.now())
                if self._task is not None:
                    self._task.advance()
                    if self._task.over:
                        self._task = None

    def see(self, scene: Scene, stamp: float | None = None) -> None:
        followed = self._goals.followed
        if followed is not None and isinstance(followed.target, str):
            scene.holder(followed.target)  # refused here, not in each cycle
        super().see(scene if self._task is None else self._task.with_taken(scene), stamp)

    def stop(self) -> StopTaken:
        """Bring the robot to rest by the soonest proven stop, on the path or off it, and drop all goals."""
        with self._commitment.journal.stage("stop"):
            taken = self._active.stop(self.problem, "requested")
        self._abandon()
        return taken

    def recover(self, goal: GoalLike, *, scaling: float = 0.1) -> bool:
        """Clear a fault, and move the robot out of light contact to a goal, slowly.

        The whole motion is judged and committed.

        Args:
            goal: A goal, as for a problem: "ready".
            scaling: Factor in (0, 1] on the limits of velocity and acceleration.

        Returns:
            Whether there is such a motion; the events give the reason if not.

        Raises:
            ProblemError: If the robot moves, or the goal or the scaling is invalid; the fault remains then.
        """
        if self.moving and np.abs(self.executor.state().velocities).max() > SLOW:
            raise ProblemError("cannot recover while the robot is moving")
        # An invalid goal or scaling is refused here, before the fault is cleared.
        replace(self.problem, goal=goal, velocity_scaling=scaling, acceleration_scaling=scaling)
        self.executor.clear_fault()
        commitment = self._commitment
        self._abandon()
        commitment.reset()
        at = self.executor.now() + self.options.ahead
        if commitment.stale(at):
            return False
        here = commitment.resting(self.problem, at, commitment.world.at(at))
        found = recovery(here, here.scene, here.start_positions, goal, scaling=scaling)
        if found.trajectory is None:
            commitment.journal.note(EventKind.NO_PLAN, found.words)
            return False
        commitment.constrained = False
        commitment.journal.note(EventKind.RECOVERING, found.words)
        return commitment.splice(found.trajectory, max(at, commitment.soonest))

    @property
    def _clock_tolerance(self) -> float:
        return self.options.clock_tolerance

    @property
    def _engaged(self) -> bool:
        return self._goals.open or self._task is not None

    def _abandon(self) -> None:
        self._goals.abandon()
        self._drop_task()

    def _drop_task(self) -> None:
        self._task, self._commitment.journal.task_stage = None, ""

    def _go(self, task: "Task", blend_radius: float) -> None:
        from trajopt.driving.driven_task import DrivenTask  # tasks are loaded when first used
        from trajopt.tasks.task import Task

        one_of("problem", task, Task)
        if blend_radius:
            raise ProblemError("blend_radius is of a goal: a task has Task(blend=...)")
        self._check_robot(task.group, task.scene)
        driven = DrivenTask(task, self._commitment, self._goals, self.options, self.gripper)
        self._abandon()
        self._task = driven

    def _check_robot(self, group: str, scene: Scene) -> None:
        if group != self.problem.group or scene.robot is not self.problem.scene.robot:
            raise ProblemError("a supervisor drives one group of one robot; make another supervisor")

    def _judge_again(self) -> None:
        journal = self._commitment.journal
        with journal.stage("re-check"):
            if self._commitment.broken():
                self._goals.interrupted()
                with journal.stage("stop"):
                    self._active.stop(self.problem, "the committed motion is no longer clear")
            self._goals.world_changed()
            if self._task is not None:
                self._task.world_changed()

    def _goal(self, problem: Problem, blend_radius: float) -> GuardedGoal:
        self._check_robot(problem.group, problem.scene)
        if not_negative("blend_radius", blend_radius) > 0.0:
            tool_of(problem.scene, problem.group)
        if moving := goals_that_move(problem):
            raise ProblemError(f"the goal moves with {', '.join(sorted(moving))}; use follow_goal")
        return GuardedGoal(problem, guard_of(problem, self.executor), blend_radius)

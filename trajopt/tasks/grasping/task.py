"""Task: the data shared by all candidates of a pick or place, and the planning of single motions."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trajopt.geometry import WorkCounts, evaluator
from trajopt.optimise.kinematics.inverse import goal_candidates
from trajopt.planning.budget import BudgetTracker, Stopped
from trajopt.planning.infeasibility import reasons
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.planning.status import Status
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import Requirement, joint_positions
from trajopt.problem.residual import Constraint
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import Grasp, GraspingOptions
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.tasks.grasping.result import Refusal, Segment, Stage
from trajopt.tasks.grasping.straight import straight_problem, to_configuration, with_room
from trajopt.values.arrays import Floats

ATTEMPTS = 16
"""Default number of seeds for each motion."""
SAME = 1e-6
"""Fingers closer than this to their target are not moved [rad | m]."""


@dataclass(frozen=True, eq=False)
class TimedConfiguration:
    """Configuration of the robot at a time.

    Attributes:
        positions: Of all joints, shape (number of joints,) [rad | m].
        time: Since the beginning of the sequence [s].
    """

    positions: Floats
    time: float = 0.0

    def after(self, segments: Sequence[Segment]) -> "TimedConfiguration":
        if not segments:
            return self
        return TimedConfiguration(segments[-1].end, self.time + sum(segment.duration for segment in segments))


@dataclass(frozen=True, eq=False, kw_only=True)
class CandidateNames:
    """Names of a candidate's grasp and place, for refusals.

    Attributes:
        grasp: The grasp; empty for none.
        place: The place; empty for none.
    """

    grasp: str = ""
    place: str = ""

    def refusal(self, stage: Stage, status: Status, reason: str, result: Result | None = None) -> Refusal:
        return Refusal(self.grasp, self.place, stage, status, reason, result)


@dataclass(frozen=True, eq=False, kw_only=True)
class PickPlaceTask:
    """The data shared by all candidates.

    Attributes:
        start: Positions of all joints before [rad | m].
        constraints: Path constraints while the object is in the hand.
        rng: Draws the starts of inverse kinematics, and the bends of seeds.
        tracker: Counts work and time, and ends the search when the budget is used up.
    """

    scene: Scene
    name: str
    start: Floats
    group: str
    gripper: Gripper
    constraints: Sequence[Requirement | Constraint]
    options: GraspingOptions
    rng: np.random.Generator
    tracker: BudgetTracker

    def reduced(self, scene: Scene, positions: Floats) -> ReducedModel:
        return reduce_model(scene, self.group, positions)

    def arm(self, positions: Floats) -> Floats:
        robot = self.scene.robot
        return positions[robot.index(robot.group(self.group).joints)]

    def opened(self, positions: Floats, opening: float) -> Floats:
        """Return positions of all joints with the fingers at an opening [m]."""
        return self.gripper.opened(self.scene.robot, positions, opening)

    def held(self, grasp: Grasp) -> Scene:
        gripper = self.gripper
        where = grasp.placement.inverse()
        return self.scene.attach(self.name, gripper.tool, placement=where, touch_links=gripper.links)

    def plan(
        self, stage: Stage, problem: Problem, candidate: CandidateNames, *, rest: float = 0.0
    ) -> Segment | Refusal:
        """Plan one motion within the remaining budget, and judge it with the rest at its end."""
        tracker, left = self.tracker, self.tracker.remaining()
        result = plan(
            replace(problem, dwell=rest) if rest and problem.scene.changing else problem,
            method=self.options.method,
            rng=self.rng,
            budget=replace(left, attempts=left.attempts or ATTEMPTS),
            cancel=tracker.cancel,
            progress=tracker.progress,
        )
        tracker.add(result.counts, result.cpu_seconds)
        if result.verified:
            return Segment(stage, result, rest)
        if result.stopped is not None:
            raise Stopped(result.stopped)
        return candidate.refusal(stage, result.status, result.reason, result)

    def configurations(
        self, reduced: ReducedModel, goals: Sequence[Requirement], stage: Stage, candidate: CandidateNames
    ) -> Sequence[Floats] | Refusal:
        """Search configurations that meet goals, nearest to the start first."""
        tracker, counts = self.tracker, WorkCounts()
        with tracker.stage("inverse kinematics"):
            try:
                found = goal_candidates(
                    evaluator(reduced, counts), goals, rng=self.rng, check=lambda: tracker.check(counts)
                )
            finally:
                tracker.count_work(counts)
        if found.free:
            return found.free[: self.options.configurations]
        status = Status.NO_INVERSE_KINEMATICS if found.blocking is None else Status.GOAL_IN_COLLISION
        return candidate.refusal(stage, status, reasons.no_goal_configuration(reduced, found, goals))

    def move(
        self, stage: Stage, scene: Scene, start: TimedConfiguration, goal: Floats, candidate: CandidateNames
    ) -> Segment | Refusal:
        """Plan the arm's free motion to positions of all joints."""
        problem = Problem(
            scene=later(scene, start.time),
            group=self.group,
            start=start.positions,
            goal=to_configuration(scene, self.group, goal),
            constraints=self.constraints if stage.holds else (),
            velocity_scaling=self.options.velocity_scaling,
            acceleration_scaling=self.options.acceleration_scaling,
            tool_speed=self.options.tool_speed,
            name=f"{stage.name.lower()} {self.name}",
        )
        return self.plan(stage, problem, candidate)

    def straight(
        self,
        stage: Stage,
        scene: Scene,
        start: TimedConfiguration,
        goal: Floats,
        candidate: CandidateNames,
        *,
        rest: float = 0.0,
    ) -> Segment | Refusal:
        """Plan the arm's straight motion to positions of all joints, with margins for its near end."""
        near = start.positions if stage in {Stage.LIFT, Stage.RETREAT} else goal
        problem = straight_problem(
            with_room(self.reduced(later(scene, start.time), near), self.arm(near)),
            start.positions,
            goal,
            group=self.group,
            tool=self.gripper.tool,
            options=self.options,
            constraints=self.constraints if stage.holds else (),
            name=f"{stage.name.lower()} {self.name}",
        )
        return self.plan(stage, problem, candidate, rest=rest)

    def fingers(
        self,
        stage: Stage,
        scene: Scene,
        start: TimedConfiguration,
        opening: float,
        candidate: CandidateNames,
        *,
        rest: float = 0.0,
    ) -> Segment | Refusal | None:
        """Plan the fingers' motion to an opening, touching the object; None if they are there already."""
        gripper = self.gripper
        goal = self.opened(start.positions, opening)
        if np.abs(goal - start.positions).max() < SAME:
            return None
        for finger in gripper.fingers if stage is not Stage.OPEN else ():
            scene = scene.allow(finger, self.name)
        problem = Problem(
            scene=_without_margins(later(scene, start.time)),
            group=gripper.group,
            start=start.positions,
            goal=joint_positions(gripper.joints_at(opening)),
            velocity_scaling=self.options.velocity_scaling,
            acceleration_scaling=self.options.acceleration_scaling,
            name=f"{stage.name.lower()} {self.name}",
        )
        return self.plan(stage, problem, candidate, rest=rest)


Step = Callable[[TimedConfiguration], Segment | Refusal | None]
"""Plans a motion from the current moment; None if nothing has to move."""


def in_turn(steps: Sequence[Step], start: TimedConfiguration) -> tuple[Segment, ...] | Refusal:
    """Plan motions in sequence; stop at the first that fails.

    Args:
        steps: Plan one motion each.
    """
    segments: list[Segment] = []
    for step in steps:
        done = step(start.after(segments))
        if isinstance(done, Refusal):
            return done
        if done is not None:
            segments.append(done)
    return tuple(segments)


def later(scene: Scene, time: float) -> Scene:
    return scene.at(time) if scene.changing else scene


def _without_margins(scene: Scene) -> Scene:
    return replace(scene, margin=0.0, pair_margins={}, kind_margins={})

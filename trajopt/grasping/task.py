"""Task: what all candidates of a pick or place share, and the planning of one motion for it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from trajopt.arrays import Floats
from trajopt.grasping.grasp import Grasp, GraspingOptions
from trajopt.grasping.gripper import Gripper
from trajopt.grasping.result import Refusal, Segment, Stage
from trajopt.grasping.straight import straight_problem, to_configuration, with_room
from trajopt.model.reduced import ReducedModel, reduce_model
from trajopt.model.requirements import Requirement, joint_positions
from trajopt.model.scene import Scene
from trajopt.planning.budget import Budget
from trajopt.planning.plan import plan
from trajopt.planning.result import Result
from trajopt.problem import Problem
from trajopt.terms.residual import Constraint

SAME = 1e-6
"""Fingers that are nearer to where they should be stay there [rad | m]."""


@dataclass(frozen=True, eq=False, kw_only=True)
class CandidateNames:
    """By what names a refusal tells of a candidate.

    Attributes:
        grasp: The grasp; empty for none.
        place: The place; empty for none.
    """

    grasp: str = ""
    place: str = ""

    def refused(self, stage: Stage, reason: str, result: Result | None = None) -> Refusal:
        """Say why the candidate was given up."""
        return Refusal(self.grasp, self.place, stage, reason, result)


@dataclass(frozen=True, eq=False, kw_only=True)
class Task:
    """What is the same for all candidates.

    Attributes:
        scene: The scene before.
        name: The object.
        start: Positions of all joints before [rad | m].
        group: The arm's planning group.
        gripper: The gripper.
        constraints: What must hold while the object is in the hand.
        options: Speeds, tolerances, times.
        rng: Draws the starts of inverse kinematics, and bends.
        counts: Takes the work done.
    """

    scene: Scene
    name: str
    start: Floats
    group: str
    gripper: Gripper
    constraints: Sequence[Requirement | Constraint]
    options: GraspingOptions
    rng: np.random.Generator
    counts: dict[str, int] = field(default_factory=dict[str, int])

    def reduced(self, scene: Scene, positions: Floats) -> ReducedModel:
        """Return the reduced model of the arm, all else standing as in positions of all joints."""
        return reduce_model(scene, self.group, positions)

    def arm(self, positions: Floats) -> Floats:
        """Pick the arm's joints out of positions of all joints."""
        robot = self.scene.robot
        return positions[robot.index(robot.group(self.group).joints)]

    def opened(self, positions: Floats, opening: float) -> Floats:
        """Return positions of all joints with the fingers at an opening [m]."""
        return self.gripper.opened(self.scene.robot, positions, opening)

    def held(self, grasp: Grasp) -> Scene:
        """Return the scene with the object attached to the hand as a grasp has it."""
        gripper = self.gripper
        where = grasp.placement.inverse()
        return self.scene.attach(self.name, gripper.tool, placement=where, touch_links=gripper.links)

    def plan(
        self, stage: Stage, problem: Problem, candidate: CandidateNames, *, rest: float = 0.0
    ) -> Segment | Refusal:
        """Plan one motion and have it judged."""
        budget = Budget(tries=self.options.attempts)
        result = plan(problem, method=self.options.method, rng=self.rng, budget=budget)
        for name, count in result.counts.items():
            self.counts[name] = self.counts.get(name, 0) + count
        if result.verified:
            return Segment(stage, result, rest)
        return candidate.refused(stage, result.reason, result)

    def move(
        self, stage: Stage, scene: Scene, start: Floats, goal: Floats, candidate: CandidateNames
    ) -> Segment | Refusal:
        """Plan the arm's free motion to positions of all joints."""
        problem = Problem(
            scene=scene,
            group=self.group,
            start=start,
            goal=to_configuration(scene, self.group, goal),
            constraints=self.constraints if stage.holds else (),
            velocity_scaling=self.options.velocity_scaling,
            acceleration_scaling=self.options.acceleration_scaling,
            name=f"{stage.name.lower()} {self.name}",
        )
        return self.plan(stage, problem, candidate)

    def straight(
        self,
        stage: Stage,
        scene: Scene,
        start: Floats,
        goal: Floats,
        candidate: CandidateNames,
        *,
        rest: float = 0.0,
    ) -> Segment | Refusal:
        """Plan the arm's straight motion to positions of all joints, with room for it at its near end."""
        near = start if stage in {Stage.LIFT, Stage.RETREAT} else goal
        problem = straight_problem(
            with_room(self.reduced(scene, near), self.arm(near)),
            start,
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
        start: Floats,
        opening: float,
        candidate: CandidateNames,
        *,
        rest: float = 0.0,
    ) -> Segment | Refusal | None:
        """Plan the fingers' motion to an opening; None if they are there.

        At the object the pads may touch it. Clear of everything is clear enough for them: the hand
        stands where the arm had to go.
        """
        gripper = self.gripper
        goal = self.opened(start, opening)
        if np.abs(goal - start).max() < SAME:
            return None
        for finger in gripper.fingers if stage is not Stage.OPEN else ():
            scene = scene.allow(finger, self.name)
        problem = Problem(
            scene=_without_margins(scene),
            group=gripper.group,
            start=start,
            goal=joint_positions(gripper.joints_at(opening)),
            velocity_scaling=self.options.velocity_scaling,
            acceleration_scaling=self.options.acceleration_scaling,
            name=f"{stage.name.lower()} {self.name}",
        )
        return self.plan(stage, problem, candidate, rest=rest)


Step = Callable[[Floats], Segment | Refusal | None]
"""Plans a motion from positions of all joints; None where nothing has to move."""


def in_turn(steps: Sequence[Step], start: Floats) -> tuple[Segment, ...] | Refusal:
    """Plan motions, each from where the one before ends; stop at the first that cannot be.

    Args:
        steps: Plan one motion each.
        start: Positions of all joints at the beginning [rad | m].
    """
    segments: list[Segment] = []
    for step in steps:
        done = step(segments[-1].end if segments else start)
        if isinstance(done, Refusal):
            return done
        if done is not None:
            segments.append(done)
    return tuple(segments)


def _without_margins(scene: Scene) -> Scene:
    return replace(scene, margin=0.0, pair_margins={})

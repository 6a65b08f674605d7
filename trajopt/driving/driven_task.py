"""Driven task: motions, gripper, and new plans."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from trajopt.driving.commit_loop import Commitment
from trajopt.driving.events import EventKind
from trajopt.driving.executor import GripperDriver
from trajopt.driving.goal_queue import GoalQueue
from trajopt.driving.intended_motion import GuardedGoal
from trajopt.driving.motion_guard import guard_of
from trajopt.driving.options import SupervisorOptions
from trajopt.geometry.geometry import supports
from trajopt.problem.requirements import FollowsCurve
from trajopt.scene.clearances import ContactAllowance
from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import FORCE, Grasp
from trajopt.tasks.grasping.gripper import Gripper
from trajopt.tasks.grasping.stages import PickObject, PlaceObject, SetGripper, hand_of, lifting_scene
from trajopt.tasks.remaining import RemainingStages, objects_of
from trajopt.tasks.result import TaskResult, TaskSegment
from trajopt.tasks.search import TaskStage, flat, held_objects, is_step_of
from trajopt.tasks.stages import FollowCurve
from trajopt.tasks.task import Task
from trajopt.timing.time_scaling import JOLT
from trajopt.values.arrays import Floats, Printed
from trajopt.values.curve import Places
from trajopt.values.errors import ProblemError, TrajoptError, shown
from trajopt.values.placement import Placement

GRIPPER_TIME = 10.0
"""Longest time of a command to the gripper [s]."""
SAMPLE = 0.02
"""Time between two places at which the way along a curve is measured [s]."""
MOVED = 2e-3
"""Deviation of an object from its planned place above which it is planned for again [m]."""
TURNED = 0.02
"""The same for its rotation [rad]."""


@dataclass(frozen=True, eq=False)
class _Command:
    """A command to the gripper that is being executed.

    Attributes:
        positions: Of all joints afterwards [rad | m].
        takes: The object that it grasps; empty for none.
        opened: Positions of all joints before a grasp, with open fingers [rad | m].
        opening: Between the pads then [m].
        segment: The planned motion of the fingers; None of a suction cup.
    """

    begun: float
    positions: Floats
    takes: str = ""
    stage: str = ""
    grasp: Grasp | None = None
    opened: Floats | None = None
    opening: float = 0.0
    segment: TaskSegment | None = None


@dataclass(eq=False)
class _Progress(Printed):
    """The plan of the stages that remain, and its progress.

    Attributes:
        fresh: Whether the plan was made in the present world, for the present state.
    """

    plan: TaskResult
    next: int = 0
    done: list[str] = field(default_factory=list[str])
    fresh: bool = True

    @property
    def segment(self) -> TaskSegment | None:
        segments = self.plan.segments
        return segments[self.next] if self.next < len(segments) else None

    def pass_by(self, steps: Sequence[str]) -> None:
        self.done += steps
        self.fresh = False

    def finish(self, segment: TaskSegment) -> None:
        self.pass_by([name for name, _ in segment.ends])
        self.next += 1

    @property
    def ahead(self) -> dict[str, Floats]:
        """Steps that remain -> positions of all joints at their ends [rad | m]."""
        return {
            name: segment.positions(min(end, segment.trajectory.duration))
            for segment in self.plan.segments[self.next :]
            for name, end in segment.ends
            if name not in self.done
        }


@dataclass(eq=False)
class DrivenTask(Printed):
    """A task that a supervisor drives.

    Its motions become goals of the supervisor. The stages that remain are planned again if a planned motion
    is no longer proven, an object of theirs is elsewhere, or the gripper holds nothing.

    Attributes:
        given_up: Whether there is no plan for the stages that remain in the world as last reported.
    """

    task: Task
    commitment: Commitment
    goals: GoalQueue
    options: SupervisorOptions
    gripper: GripperDriver | None
    given_up: bool = False
    over: bool = False
    _progress: _Progress | None = None
    _running: TaskSegment | None = None
    _command: _Command | None = None
    _failed: dict[str, list[Grasp]] = field(default_factory=dict[str, list[Grasp]])
    _absent: set[str] = field(default_factory=set[str])
    _taken: frozenset[str] = frozenset()
    _allowed: tuple[ContactAllowance, ...] = ()
    _not_before: float = -inf
    _lead: float = 0.0
    _hand: Gripper | None = None
    _begun_at: float = 0.0
    _stages: Sequence[TaskStage] = field(init=False)
    _positions: Floats = field(init=False)
    _expected: Scene = field(init=False)

    def __post_init__(self) -> None:
        task, gripper = self.task, self.gripper
        self._stages, self._expected = task.stages, task.scene
        self._positions = task.start_positions
        moved = [
            stage for stage in flat(task.stages) if isinstance(stage, SetGripper | PickObject | PlaceObject)
        ]
        if gripper is None:
            if moved:
                fingers = f"stage {shown(moved[0].name)} moves fingers"
                raise ProblemError(f"{fingers}: pass their driver to the supervisor (gripper=)")
            return
        if gripper.state().holding:
            self._taken = held_objects(task.scene)
        if moved:
            hand = self._hand = _only_hand(task, moved)
            both = sorted(set(self.commitment.executor.joint_names) & set(hand.joint_names))
            if both:
                raise ProblemError(
                    f"the executor drives {', '.join(both)}, which the gripper moves: leave them out of it"
                )
            opening = float(np.clip(gripper.state().opening, hand.narrowest, hand.widest))
            self._positions = hand.opened(task.scene.robot, self._positions, opening)

    def advance(self) -> None:
        """Begin the next motion or command."""
        now, progress = self.commitment.executor.now(), self._progress
        if self._lost() or (self._command is not None and not self._obeyed(self._command, now)):
            return
        if self.goals.given_up:
            self._withdraw()
        if self.goals.open:
            return
        if self._running is not None:
            self._finish(self._running, now)
        if now < max(self._not_before, self.commitment.motion.end):
            return
        progress = self._progress
        if progress is None:
            self._plan(now)
        elif progress.segment is not None:
            self._begin(progress, progress.segment, now)
        elif self._modelled(progress.plan.final_scene, now):
            self._complete()

    def with_taken(self, scene: Scene) -> Scene:
        """Return a reported scene with the objects in the gripper, and the contacts of the present motion."""
        model = self.commitment.world.scene
        for name in sorted(self._taken & held_objects(model)):
            scene = replace(scene, objects={**scene.objects, name: model.objects[name]})
        return replace(scene, allowances=(*_without(scene.allowances, self._allowed), *self._allowed))

    def world_changed(self) -> None:
        """Plan again if there was no plan, or if an object of a remaining stage is elsewhere or missing."""
        if self.given_up:
            self.given_up, self._not_before = False, -inf
        if self._progress is not None:
            self._progress.fresh = False
        moved = self._moved()
        for stage in flat(self._stages):
            if objects_of(stage, self._expected, self.task.group).intersection(moved):
                self._failed.pop(stage.name, None)
        self._absent.difference_update(moved)
        if moved and self._command is None:
            self._withdraw()

    def _moved(self) -> list[str]:
        scene, before = self.commitment.world.scene, self._expected
        left = self._remaining().of(self._stages)
        names = {name for stage in flat(left) for name in objects_of(stage, before, self.task.group)}
        standing = names - self._taken - held_objects(scene) - {*before.changing, *scene.changing}
        return [name for name in sorted(standing) if _elsewhere(name, before, scene)]

    def _remaining(self) -> RemainingStages:
        progress = self._progress
        return RemainingStages(
            scene=self.commitment.world.scene,
            group=self.task.group,
            done=() if progress is None else progress.done,
            ahead={} if progress is None else progress.ahead,
            failed=self._failed,
            followed=self._followed_lengths(),
            absent=self._absent,
        )

    def _followed_lengths(self) -> dict[str, float]:
        """Return stage -> length along its curve at which the arm comes to rest, if it is on one [m]."""
        running = self._running
        if running is None:
            return {}
        on = [each for each in flat(self._stages) if isinstance(each, FollowCurve)]
        return {
            stage.name: min(self._travelled(stage.curve, running), stage.curve.until)
            for stage in on
            if running.stages == (stage.name,)
        }

    def _travelled(self, required: FollowsCurve, running: TaskSegment) -> float:
        """Return the length along a curve at the place of the motion that is nearest to its end."""
        scene, motion = running.scene, running.trajectory
        latest = min(max(self.commitment.motion.end - self._begun_at, 0.0), motion.duration)
        times = np.linspace(0.0, latest, 2 + int(latest / SAMPLE))
        here = self._here()[scene.robot.index(motion.joint_names)]
        last = int(np.linalg.norm(motion(times) - here, axis=1).argmin())
        point = Placement(translation=required.offset)
        seen: list[Placement] = []
        for time in times[: last + 1].tolist():
            at = running.positions(time)
            reference = scene.placement_of(required.reference, at).inverse()
            seen.append(reference * scene.placement_of(required.frame, at) * point)
        places = Places(
            np.array([each.rotation for each in seen]), np.array([each.translation for each in seen])
        )
        fixed = required.spin is None and np.isfinite(required.rotation_tolerance)
        return required.curve.travelled(places, turns=bool(fixed))

    def _withdraw(self) -> None:
        ahead, progress, running = self.goals.withdraw(), self._progress, self._running
        if progress is None:
            return
        if running is not None:
            progress.pass_by([name for name in running.stages[:-1] if name not in ahead])
        self._drop_plan()

    def _drop_plan(self) -> None:
        remaining = self._remaining()
        self._stages = remaining.of(self._stages)
        self._progress = self._running = None
        for name, why in remaining.skipped.items():
            self.commitment.journal.task_stage = ""
            self.commitment.journal.note(EventKind.SKIPPED, f"part {name}: {why}")

    def _plan(self, now: float) -> None:
        commitment, options = self.commitment, self.options
        self._drop_plan()
        if not self._stages:
            self._complete()
            return
        commitment.journal.task_stage = ""
        at = max(commitment.motion.end + 2.0 * JOLT, now + max(options.ahead, self._lead))
        words = commitment.world.stale(at) or self._why_missing()
        if not words:
            with commitment.journal.stage("plan"):
                words = self._planned(at)
        self._lead = 2.0 * (commitment.executor.now() - now)
        if words:
            self._give_up(words)

    def _why_missing(self) -> str:
        remaining = self._remaining()
        for stage in flat(self._stages):
            for name, why in remaining.missing((stage,)).items():
                return f"stage {shown(stage.name)}, part {name}: {why}"
        return ""

    def _planned(self, at: float) -> str:
        """Plan for a begin on the executor's clock [s]; return why there is no plan."""
        commitment, options = self.commitment, self.task.options
        scene, here = commitment.planning_scene(at, commitment.world), self._here()
        scene = replace(
            scene,
            allowances=_without(scene.allowances, self._allowed),
            pair_margins=self.task.scene.pair_margins,
        )
        for name in sorted(held_objects(scene)):
            stands_on = supports(scene, name, scene.placement_of(name, here))
            scene = lifting_scene(scene, name, stands_on, options.contact_time)
        try:
            task = replace(self.task, scene=scene, start=here, stages=self._stages)
            result = task.planned(budget=replace(self.options.budget, improve=False))
        except TrajoptError as error:
            return str(error)
        if not result.verified:
            return self._cause(result)
        self._progress, self._expected, self.given_up = _Progress(result), scene, False
        commitment.journal.note(EventKind.PLANNED, result.reason)
        return ""

    def _cause(self, result: TaskResult) -> str:
        refusal = next((item for item in result.refusals if item.stage == result.failed), None)
        if refusal is None:
            return result.reason
        stage = next(each for each in flat(self._stages) if is_step_of(refusal.stage, each))
        part = refusal.names.object
        step = refusal.stage.removeprefix(stage.name).removeprefix(": ")
        which = (step, refusal.names.grasp, refusal.names.place, refusal.reason)
        named = f"stage {shown(stage.name)}" + f", part {part}" * bool(part)
        return ": ".join((named, *filter(None, which)))

    def _give_up(self, words: str) -> None:
        changing = bool(self.commitment.world.scene.changing)
        self._not_before = self.commitment.executor.now() + self.options.retry if changing else inf
        self.given_up = not changing
        self.commitment.journal.note_once(EventKind.NO_PLAN, words)

    def _complete(self) -> None:
        self.over = True
        self.commitment.journal.task_stage = ""
        self.commitment.journal.note(EventKind.COMPLETED, f"task {shown(self.task.name)}")

    def _begin(self, progress: _Progress, segment: TaskSegment, now: float) -> None:
        problem, commitment = segment.result.problem, self.commitment
        if not progress.fresh and self._moved():
            self._drop_plan()
            return
        commitment.journal.task_stage = segment.title
        if problem.group != self.task.group:
            self._update_world(segment.scene)
            self._move_fingers(segment, now)
            return
        if not self._modelled(segment.scene, now):
            return
        goal = GuardedGoal(problem, guard_of(problem, commitment.executor))
        at = max(commitment.motion.end + 2.0 * JOLT, now + self.options.ahead)
        if self.goals.drive(goal, segment.result.require(), at):
            self._running, self._begun_at = segment, at
            return
        if progress.fresh:
            why = goal.guard.failed_check(segment.trajectory, commitment.world, at)
            self._give_up(f"the planned motion is not proven: {why}")
        self._drop_plan()

    def _finish(self, segment: TaskSegment, now: float) -> None:
        if self._progress is not None:
            self._progress.finish(segment)
        self._positions, self._running = segment.end, None
        self._not_before = now + segment.rest

    def _here(self) -> Floats:
        """Return the positions of all joints, the fingers' as in the plan."""
        motion, robot = self.commitment.motion, self.task.scene.robot
        positions = np.array(self._positions)
        positions[robot.index(motion.joint_names)] = motion(inf)[0]
        return robot.followed(positions)

    def _modelled(self, scene: Scene, now: float) -> bool:
        """Update the world for the next motion; return False while a suction cup switches."""
        held, wanted = held_objects(self.commitment.world.scene), held_objects(scene)
        if self.gripper is not None:
            here, opening = self._here(), self.gripper.state().opening
            if left := self._taken & (held - wanted):
                self.gripper.move(opening)
                self._release(left)
                self._command = _Command(now, here)
                return False
            for name in sorted(wanted - held - self._taken):
                self.gripper.grasp(opening, FORCE)
                self._command = _Command(now, here, takes=name, opened=here, opening=opening)
                return False
        self._update_world(scene)
        return True

    def _update_world(self, scene: Scene) -> None:
        world, here, before = self.commitment.world, self._here(), self._expected
        model = world.scene
        held, wanted = held_objects(model), held_objects(scene) & set(model.objects)
        for name in sorted(held - wanted):
            model = model.detach(name, at=here)
        for name in sorted(wanted - held):
            item = scene.objects[name]
            model = model.attach(name, item.frame, at=here, touch_links=item.touch_links)
        static = set(model.objects) & set(scene.objects) & set(before.objects) - set(scene.changing)
        for name in sorted(static - held - wanted - held_objects(before)):
            if _elsewhere(name, before, scene):
                model = model.move(name, scene.objects[name].placement)
        usual = _without(model.allowances, self._allowed)
        self._allowed = _without(scene.allowances, usual)
        model = replace(model, allowances=(*usual, *self._allowed), pair_margins=scene.pair_margins)
        self.commitment.world, self._expected = world.updated(model, world.stamp), scene

    def _move_fingers(self, segment: TaskSegment, now: float) -> None:
        stage = next(each for each in flat(self._stages) if is_step_of(segment.stages[0], each))
        assert isinstance(stage, SetGripper | PickObject | PlaceObject)
        assert self.gripper is not None
        scene, opened = segment.scene, segment.positions(0.0)
        hand = self._hand
        assert hand is not None
        if not isinstance(stage, PickObject) or not segment.stages[0].endswith(": close"):
            self.gripper.move(hand.opening_at(scene.robot, segment.end))
            self._release(self._taken)
            self._command = _Command(now, segment.end, segment=segment)
            return
        grasp = _nearest_grasp(stage, scene, hand, opened)
        self.gripper.grasp(grasp.width, grasp.force)
        self._command = _Command(
            now,
            segment.end,
            takes=stage.object,
            stage=stage.name,
            grasp=grasp,
            opened=opened,
            opening=hand.opening_at(scene.robot, opened),
            segment=segment,
        )

    def _release(self, names: frozenset[str]) -> None:
        self._taken -= names
        for name in sorted(names):
            self.commitment.journal.note(EventKind.RELEASED, name)

    def _obeyed(self, command: _Command, now: float) -> bool:
        """Return whether the gripper has finished a command; if it holds nothing, plan again."""
        assert self.gripper is not None
        state = self.gripper.state()
        if state.moving and now < command.begun + GRIPPER_TIME:
            return False
        self._command = None
        if not command.takes:
            self._followed(command, now)
        elif state.holding and not state.moving:
            self.commitment.journal.note(EventKind.GRASPED, command.takes)
            self._taken |= {command.takes}
            self._followed(command, now)
        else:
            self._missed(command, self.gripper, now)
        return self._command is None

    def _followed(self, command: _Command, now: float) -> None:
        self._positions = command.positions
        if command.segment is not None:
            self._finish(command.segment, now)

    def _missed(self, command: _Command, gripper: GripperDriver, now: float) -> None:
        which = f" by {command.grasp.name}" if command.grasp is not None else ""
        words = f"part {command.takes}{which}: the gripper holds nothing"
        self.commitment.journal.note(EventKind.NOT_GRASPED, words)
        assert command.opened is not None
        if command.grasp is None:
            self._absent.add(command.takes)
        else:
            self._failed.setdefault(command.stage, []).append(command.grasp)
        gripper.move(command.opening)
        self._drop_plan()
        self._command = _Command(now, command.opened)

    def _lost(self) -> bool:
        if not self._taken or self._command is not None or self.gripper is None:
            return False
        if self.gripper.state().holding:
            return False
        world = self.commitment.world
        scene = world.scene
        for name in sorted(self._taken & set(scene.objects)):
            self.commitment.journal.note(EventKind.LOST, f"part {name}: the gripper no longer holds it")
            scene = scene.remove(name)
        self._taken, self.commitment.world = frozenset(), world.updated(scene, world.stamp)
        self._withdraw()
        return True


def _without(
    allowances: Sequence[ContactAllowance], other: Sequence[ContactAllowance]
) -> tuple[ContactAllowance, ...]:
    return tuple(each for each in allowances if each not in other)


def _elsewhere(name: str, before: Scene, now: Scene) -> bool:
    if name not in now.objects:
        return True
    away = before.holder(name).placement.inverse() * now.holder(name).placement
    turned = float(np.arccos(np.clip((np.trace(away.rotation) - 1.0) / 2.0, -1.0, 1.0)))
    return float(np.linalg.norm(away.translation)) > MOVED or turned > TURNED


def _only_hand(task: Task, moved: Sequence[SetGripper | PickObject | PlaceObject]) -> Gripper:
    picked = {stage.object for stage in moved if isinstance(stage, PickObject)}
    hands = {
        hand.tool: hand
        for stage in moved
        if not (isinstance(stage, PlaceObject) and stage.gripper is None and stage.object in picked)
        for hand in (hand_of(task.scene, stage.gripper, task.group),)
    }
    if len(hands) > 1:
        tools = ", ".join(map(shown, hands))
        raise ProblemError(f"the task moves the grippers of {tools}, but only one can be driven")
    return next(iter(hands.values()))


def _nearest_grasp(stage: PickObject, scene: Scene, hand: Gripper, positions: Floats) -> Grasp:
    tool = scene.placement_of(stage.object, positions).inverse() * scene.placement_of(hand.tool, positions)

    def distance(grasp: Grasp) -> float:
        return float(np.abs(grasp.placement.homogeneous - tool.homogeneous).max())

    return min(stage.grasps, key=distance)

"""Problem: the frozen specification of a motion, readable when printed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path

from trajopt.geometry import MakesEvaluator, evaluator
from trajopt.geometry.geometry import inside_carriers
from trajopt.problem.requirements import During, GoalSet, Requirement
from trajopt.problem.residual import Constraint, Cost, check_path_constraint
from trajopt.problem.smoothness import default_costs
from trajopt.problem.stated import (
    GoalLike,
    check_goal,
    check_names,
    check_waypoints,
    in_motion,
    only_group,
    start_rates,
    stated_dwell,
    stated_goal,
    stated_knots,
    stated_rates,
    stated_waypoints,
)
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
from trajopt.robot.joints import JointLimits, LimitKind
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, name_of, number, one_of, sequence, several
from trajopt.values.errors import ProblemError, ProblemNotFound, WaypointNotFound, shown
from trajopt.values.errors.arguments import checked_class
from trajopt.values.printed import in_short

PathConstraint = Requirement | Constraint
"""A constraint along the motion: a requirement, which is plain data, or a residual with bounds."""


@checked_class
@dataclass(frozen=True, eq=False, kw_only=True)
class Problem(Value):
    """A planning problem: from a start to a goal under constraints, at least cost.

    Attributes:
        start: State name (of the group; other groups take their state of that name), joint -> position
            [rad | m], positions of the group's joints or of all joints, or a plan or result, whose end is
            taken. Unnamed joints are as near to zero as their limits allow; mimic joints follow.
        goal: Requirements at the end: one or several, or any one goal of a set (`any_of`). The forms of a
            start mean `joint_positions` of the group; a placement means `frame_placement` of the group's
            tool: its tool frame, the tool frame of its only end effector, or the tip of its chain. The
            printed problem names it.
        group: Planning group; optional if the robot has one only.
        constraints: Requirements for the whole motion or between waypoints (`during`): plain requirements, or
            your own residuals with bounds.
        waypoints: Requirements on the way, in order, by name or in a sequence with the names "1", "2", ...;
            each has the form of a goal and holds at one moment that the planner chooses. The motion passes
            it without a stop, unless only a stop holds the tolerance.
        costs: Terms to minimise; squared velocity and acceleration by default.
        knots: Number of knots of the path, 3 to 2000. 0 selects 24, or 48 for a base with driven wheels, or 8
            for each leg between waypoints if that is more. Twice as many if the judge refuses the motion.
        velocity_scaling, acceleration_scaling: Factors in (0, 1] on the limits.
        start_velocity: Joint of the group -> start velocity [rad/s | m/s]; other joints are at rest.
        start_acceleration: Joint of the group -> start acceleration [rad/s^2 | m/s^2]; zero for others.
        dwell: Time for which the robot stays clear at the goal, at rest, after the end [s]. With a moving
            goal the motion includes this time: it follows the goal and ends at rest relative to it.
        finish_by: Deadline at the goal, on a clock that shows 0 at the start of the motion [s]; none by
            default.
        evaluator: Computes kinematics and distances for planning; the native evaluator by default. Files
            cannot contain it, and the judge does not use it.
        degrees: Whether angles are in degrees in `start`, `start_velocity`, `start_acceleration`, and in
            joint positions by name in `goal` and `waypoints`.
    """

    scene: Scene
    start: ConfigurationLike
    goal: GoalLike | Sequence[GoalLike] | GoalSet
    group: str = ""
    constraints: Sequence[PathConstraint | During[PathConstraint]] = ()
    waypoints: Sequence[GoalLike | Sequence[GoalLike]] | Mapping[str, GoalLike | Sequence[GoalLike]] = ()
    costs: Sequence[Cost] | None = None
    knots: int = 0
    velocity_scaling: float = 1.0
    acceleration_scaling: float = 1.0
    tool_speed: ToolSpeed | Sequence[ToolSpeed] = ()
    start_velocity: Mapping[str, float] = field(default_factory=dict[str, float])
    start_acceleration: Mapping[str, float] = field(default_factory=dict[str, float])
    dwell: float = 0.0
    finish_by: float | None = None
    name: str = "problem"
    evaluator: MakesEvaluator = field(default=evaluator, repr=False)
    degrees: InitVar[bool] = False
    _start: Floats = field(init=False, repr=False)
    _by_name: Mapping[str, tuple[Requirement, ...]] = field(init=False, repr=False)
    _goals: tuple[Requirement, ...] = field(init=False, repr=False)
    _waypoints: Mapping[str, tuple[Requirement, ...]] = field(init=False, repr=False)
    _tool_speeds: tuple[ToolSpeed, ...] = field(init=False, repr=False)

    def __post_init__(self, degrees: bool) -> None:
        robot = one_of("scene", self.scene, Scene).robot
        name_of("name", self.name)
        object.__setattr__(self, "group", one_of("group", self.group, str) or only_group(robot))
        if not robot.group(self.group).joints:
            raise ProblemError(f"group {shown(self.group)} has no joint to move")
        start = stated_configuration(robot, "start", self.start, group=self.group, degrees=degrees)
        goal = stated_goal(self.scene, self.group, self.goal, degrees=degrees)
        by_name, goals = (goal, tuple(chain(*goal.values()))) if isinstance(goal, dict) else ({}, goal)
        constraints = tuple(sequence("constraints", self.constraints))
        if not goals:
            raise ProblemError(
                "a problem needs a goal: joint_positions(...), frame_placement(...) or several"
            )
        for item in constraints:
            check_path_constraint(item.required if isinstance(item, During) else item)
        waypoints = stated_waypoints(self.scene, self.group, self.waypoints, degrees=degrees)
        knots = stated_knots(robot, self.group, self.knots, len(waypoints))
        object.__setattr__(self, "knots", knots)
        check_waypoints(waypoints, knots)
        costs = default_costs() if self.costs is None else several("costs", self.costs, Cost)
        speeds = (self.tool_speed,) if isinstance(self.tool_speed, ToolSpeed) else self.tool_speed
        tools = several("tool_speed", speeds, ToolSpeed)
        for rates in ("start_velocity", "start_acceleration"):
            stated = stated_rates(robot, rates, getattr(self, rates), degrees=degrees)
            object.__setattr__(self, rates, stated)
        names = ("start", "_start", "goal", "_by_name", "_goals", "constraints", "costs")
        values = (start, start, GoalSet(by_name) if by_name else goals, by_name, goals, constraints, costs)
        names += ("waypoints", "_waypoints", "tool_speed", "_tool_speeds")
        for name, value in zip(names, (*values, waypoints, waypoints, tools, tools), strict=True):
            object.__setattr__(self, name, value)
        self._check_contents((*chain(*waypoints.values()), *constraints))

    def _check_contents(self, required: Iterable[PathConstraint | During[PathConstraint]]) -> None:
        for label in ("velocity_scaling", "acceleration_scaling"):
            if not 0.0 < number(label, getattr(self, label)) <= 1.0:
                raise ProblemError(f"{label} is a factor in (0, 1], is {getattr(self, label)}")
        object.__setattr__(self, "dwell", stated_dwell(self.dwell))
        for goal in self._goals:
            check_goal(self.scene, goal, in_motion=self.starts_moving)
        if self.finish_by is not None and number("finish_by", self.finish_by) <= 0.0:
            raise ProblemError(f"finish_by must be after the start, at 0 s, is {self.finish_by:g} s")
        for item in required:
            self._check_names(item)
        for part in self.partial:
            self.span(part)
        for tool in self._tool_speeds:
            self.scene.holder(tool.frame)
        if self.start_velocity:
            _ = self.start_velocities  # names and sizes are checked there
        if self.start_acceleration:
            _ = self.start_accelerations

    @property
    def reduced(self) -> ReducedModel:
        return self._reduced

    @cached_property
    def _reduced(self) -> ReducedModel:
        # Apart from `reduced`, as a protocol's property matches no cached property.
        return reduce_model(self.scene, self.group, self.start_positions)

    @cached_property
    def limits(self) -> JointLimits:
        """Scaled limits of the group's joints, tightened to the limits of their mimic joints."""
        return self.reduced.limits.scaled(
            velocity=self.velocity_scaling, acceleration=self.acceleration_scaling
        )

    @cached_property
    def moving_limits(self) -> JointLimits:
        """Scaled limits of the group's joints and of their mimic joints, each as stated."""
        robot = self.scene.robot
        return robot.limits.take(robot.index(self.reduced.moving_joints)).scaled(
            velocity=self.velocity_scaling, acceleration=self.acceleration_scaling
        )

    @property
    def start_positions(self) -> Floats:
        """Positions of all joints at the start, shape (number of joints,) [rad | m]."""
        return self._start

    @property
    def goals(self) -> tuple[Requirement, ...]:
        """Requirements at the end.

        Raises:
            ProblemError: If the goal is a set; each of its `alternatives` has its own goals.
        """
        if isinstance(self.goal, GoalSet):
            raise ProblemError(f"the goal is {self.goal}, a set: use one of the problem's alternatives")
        return self._goals

    @cached_property
    def alternatives(self) -> Mapping[str, Problem]:
        """One problem for each goal of the goal set, by the goal's name; empty without a goal set."""
        return {name: replace(self, goal=goal) for name, goal in self._by_name.items()}

    @property
    def tool_speeds(self) -> tuple[ToolSpeed, ...]:
        """Largest tool speeds."""
        return self._tool_speeds

    @property
    def waypoint_requirements(self) -> tuple[tuple[Requirement, ...], ...]:
        """Requirements at each waypoint, in order."""
        return tuple(self._waypoints.values())

    @property
    def waypoint_names(self) -> tuple[str, ...]:
        """Names of the waypoints, in order."""
        return tuple(self._waypoints)

    @property
    def partial(self) -> tuple[During[PathConstraint], ...]:
        """Requirements on a part of the motion."""
        return tuple(item for item in self.constraints if isinstance(item, During))

    def span(self, part: During[PathConstraint]) -> tuple[int, int]:
        """Return the first and last stop of a part; see `requirements_at`.

        Raises:
            WaypointNotFound: If it names an unknown waypoint.
            ProblemError: If it ends before it begins.
        """
        names = self.waypoint_names
        for name in (part.after, part.until):
            if name is not None and name not in names:
                raise WaypointNotFound("waypoint", name, names)
        first = 0 if part.after is None else 1 + names.index(part.after)
        last = self.last_stop if part.until is None else 1 + names.index(part.until)
        if first >= last:
            raise ProblemError(f"{part}: ends before it begins")
        return first, last

    def requirements_at(self, stop: int) -> tuple[Requirement, ...]:
        """Return the requirements that hold while passing a stop.

        Stop 0 is the start, followed by the waypoints and the end.
        """
        spans = ((part, self.span(part)) for part in self.partial)
        here = (part.required for part, (first, last) in spans if first <= stop <= last)
        return (*self.requirements, *(item for item in here if isinstance(item, Requirement)))

    @cached_property
    def start_velocities(self) -> Floats:
        """Velocities of the group's joints at the start, shape (n,) [rad/s | m/s]."""
        return start_rates(self.start_velocity, LimitKind.VELOCITY, self.limits, self.scene.robot.model)

    @cached_property
    def start_accelerations(self) -> Floats:
        """Accelerations of the group's joints at the start, shape (n,) [rad/s^2 | m/s^2]."""
        stated, kind = self.start_acceleration, LimitKind.ACCELERATION
        return start_rates(stated, kind, self.limits, self.scene.robot.model)

    @property
    def starts_moving(self) -> bool:
        """Whether the start has a velocity or an acceleration."""
        return any((*self.start_velocity.values(), *self.start_acceleration.values()))

    @property
    def last_stop(self) -> int:
        """Index of the end among the stops: 0 is the start, then the waypoints."""
        return 1 + len(self._waypoints)

    @property
    def all_requirements(self) -> tuple[Requirement, ...]:
        """All plain requirements: path constraints, goals and waypoints."""
        partial = (item.required for item in self.partial if isinstance(item.required, Requirement))
        return (*self.requirements, *partial, *self.goals, *chain(*self.waypoint_requirements))

    @property
    def residual_constraints(self) -> tuple[Constraint, ...]:
        """Constraints on the whole motion in code, which the judge samples."""
        return tuple(item for item in self.constraints if isinstance(item, Constraint))

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """Plain requirements on the whole motion, which the judge can prove."""
        return tuple(item for item in self.constraints if isinstance(item, Requirement))

    def _check_names(self, item: PathConstraint | During[PathConstraint]) -> None:
        if isinstance(item, During):
            self._check_names(item.required)
        if isinstance(item, Requirement):
            check_names(self.scene, item)

    def save(self, path: Path | str) -> None:
        """Write the problem to a bundle without a result; see `Result.save`.

        Raises:
            ModelError: If the problem contains user code, which files cannot contain.
            FileFormatError: If the file cannot be written.
        """
        from trajopt.files.bundle import save

        save(self, path)

    def __repr__(self) -> str:
        goal = self.goal if isinstance(self.goal, GoalSet) else " and ".join(map(str, self.goals))
        where = f"{self.scene.robot.name}, group {self.group}"
        return in_short(f"Problem({shown(self.name)}: {where}, to {goal})")

    def __str__(self) -> str:
        ends = (self.goal,) if isinstance(self.goal, GoalSet) else self.goals
        moving = in_motion(self.scene.robot.model, self.start_velocity, self.start_acceleration)
        speeds = ((self.velocity_scaling, "velocity"), (self.acceleration_scaling, "acceleration"))
        slower = ", ".join(f"{share:g} of the {name} limits" for share, name in speeds if share < 1.0)
        lines = [
            f"Problem {shown(self.name)}: {self.scene.robot.name}, group {self.group}, {self.knots} knots",
            *((f"  from         {moving}",) if moving else ()),
            *(f"  {what:<12} {words}" for what, words in self.scene.described),
            *(f"  carried      {words}" for words in inside_carriers(self.reduced)),
            *(
                f"  on the way   {name}: {' and '.join(each.in_full() for each in item)}"
                for name, item in zip(self.waypoint_names, self.waypoint_requirements, strict=True)
            ),
            *(f"  at the end   {end if isinstance(end, GoalSet) else end.in_full()}" for end in ends),
            *(
                f"  {item.part}  {_words(item.required)}"
                if isinstance(item, During)
                else f"  all the way  {_words(item)}"
                for item in self.constraints
            ),
            *(f"  no faster    {tool}" for tool in self.tool_speeds),
            "  minimise     "
            + " + ".join(f"{cost.weight:g} x {cost.residual.name}" for cost in self.costs or ()),
            *((f"  no faster    {slower}",) if slower else ()),
            *((f"  stays        {self.dwell:g} s at the goal",) if self.dwell else ()),
            *(() if self.finish_by is None else (f"  finished by  {self.finish_by:g} s",)),
        ]
        return "\n".join(lines)


def _words(item: PathConstraint) -> str:
    return item.in_full() if isinstance(item, Requirement) else item.residual.name


def named_problem(name: str) -> Problem:
    """Return an installed problem by name ("cup_past_pillar").

    The entry-point group `trajopt.problems` adds names.

    Raises:
        ProblemNotFound: If the name is unknown.
    """
    from importlib.metadata import entry_points

    installed = {entry.name: entry for entry in entry_points(group="trajopt.problems")}
    if str(name) not in installed:
        raise ProblemNotFound("installed problem", name, installed)
    return installed[str(name)].load()()

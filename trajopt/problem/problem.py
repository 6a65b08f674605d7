"""Problem: what a motion must achieve, frozen; it says what it is when printed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path

from trajopt.geometry import MakesEvaluator, evaluator
from trajopt.geometry.gap import inside_carriers
from trajopt.problem.knots import stated_knots
from trajopt.problem.requirements import During, GoalSet, Requirement
from trajopt.problem.residual import Constraint, Cost, check_path_constraint
from trajopt.problem.smoothness import default_costs
from trajopt.problem.starting import in_motion, start_rates
from trajopt.problem.stated import (
    GoalLike,
    check_goal,
    check_names,
    check_waypoints,
    only_group,
    stated_dwell,
    stated_goal,
    stated_rates,
    stated_waypoints,
)
from trajopt.problem.tool_speed import ToolSpeed
from trajopt.robot.configuration import ConfigurationLike, stated_configuration
from trajopt.robot.limits import JointLimits, LimitKind
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, Value, name_of, number, one_of, sequence, several
from trajopt.values.errors import ProblemError, ProblemNotFound, WaypointNotFound, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_short

PathConstraint = Requirement | Constraint
"""What must hold on the way: a requirement, which is plain data, or a residual with bounds."""


@checked
@dataclass(frozen=True, eq=False, kw_only=True)
class Problem(Value):
    """A planning problem: from a start to a goal, holding constraints, at least cost.

    Attributes:
        scene: The robot and what is around it, with the clearance to keep.
        start: Name of a state (the group's; other groups stand in theirs of that name), joint -> position
            [rad | m], positions of the group's joints or of all joints, or a plan or result, for its end.
            Joints that are not given are as near to zero as their limits allow; mimic joints follow.
        goal: What must hold at the end: one requirement or several, or any one goal of a set (`any_of`). The
            forms of a start stand for `joint_positions` of the group, a placement for `frame_placement` of
            the group's tool: its tool frame, or the tool frame of its one end effector, or the tip of its
            chain; the printed problem names it.
        group: The planning group; may be left out where the robot has one only.
        constraints: What must hold all the way, or between waypoints (`during`): requirements, or
            residuals of your own with bounds.
        waypoints: What must hold on the way, in order, by name, or in a sequence and then named "1", "2",
            ...: for each what a goal may be, held at one moment that the planner chooses.
            The motion passes it without a stop, unless it could not hold the tolerance otherwise.
        costs: What to minimise; squared velocity and acceleration by default.
        knots: Number of knots of the path, from 3 to 2000; when 0: 24, or 48 where a base's wheels roll, or 8
            for each leg between waypoints if those are more.
        velocity_scaling: Factor in (0, 1] on the velocity limits.
        acceleration_scaling: Factor in (0, 1] on the acceleration limits.
        tool_speed: Largest speeds of tools: one limit or several.
        start_velocity: Joint of the group -> its velocity at the start [rad/s | m/s]; joints that are not
            named are at rest.
        start_acceleration: The same for accelerations [rad/s^2 | m/s^2]; joints that are not named have none.
        dwell: How long the robot stays clear at the goal, at rest, after the end [s]. A goal that moves it
            follows for so long, and the motion includes that; it ends at rest as seen from the goal.
        finish_by: When the robot must be at the goal, by the clock that shows 0 when the motion starts [s];
            any time when None.
        name: For reports.
        evaluator: Makes the kinematics and distances that planning works with; the native ones by default.
            It is code, which no file can hold, and the judge does not use it.
        degrees: Whether angles are in degrees in `start`, `start_velocity`, `start_acceleration`, and where
            joints are given by name in `goal` and `waypoints`.
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
        """Keep each field in one form, its exact type under an underscore, and check names and numbers."""
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

    @cached_property
    def reduced(self) -> ReducedModel:
        """The robot with only the group's joints free."""
        return reduce_model(self.scene, self.group, self.start_positions)

    @cached_property
    def limits(self) -> JointLimits:
        """Limits of the group's joints, which keep those of mimic joints too, with the factors applied."""
        return self.reduced.limits.scaled(
            velocity=self.velocity_scaling, acceleration=self.acceleration_scaling
        )

    @cached_property
    def moving_limits(self) -> JointLimits:
        """Limits of the group's joints and of their mimic joints, as stated, with the factors applied."""
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
        """What must hold at the end.

        Raises:
            ProblemError: If the goal is a set; each of its `alternatives` has goals of its own.
        """
        if isinstance(self.goal, GoalSet):
            raise ProblemError(f"the goal is {self.goal}: take one of the problem's alternatives")
        return self._goals

    @cached_property
    def alternatives(self) -> Mapping[str, Problem]:
        """The problem with each goal of its goal set alone, by the goal's name; empty for one goal."""
        return {name: replace(self, goal=goal) for name, goal in self._by_name.items()}

    @property
    def tool_speeds(self) -> tuple[ToolSpeed, ...]:
        """Largest speeds of tools."""
        return self._tool_speeds

    @property
    def waypoint_requirements(self) -> tuple[tuple[Requirement, ...], ...]:
        """What must hold at each waypoint, in order."""
        return tuple(self._waypoints.values())

    @property
    def waypoint_names(self) -> tuple[str, ...]:
        """The names of the waypoints, in order."""
        return tuple(self._waypoints)

    @property
    def partial(self) -> tuple[During[PathConstraint], ...]:
        """What must hold on a part of the motion only."""
        return tuple(item for item in self.constraints if isinstance(item, During))

    @checked
    def span(self, part: During[PathConstraint]) -> tuple[int, int]:
        """Return the first and the last stop of a part: 0 is the start, then the waypoints, then the end.

        Raises:
            WaypointNotFound: If it names a waypoint that is not there.
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

    @checked
    def requirements_at(self, stop: int) -> tuple[Requirement, ...]:
        """Return what must hold on the way past a stop: 0 is the start, then the waypoints, then the end."""
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
        """Whether the start is in motion."""
        return any((*self.start_velocity.values(), *self.start_acceleration.values()))

    @property
    def last_stop(self) -> int:
        """The number of the end among the stops: 0 is the start, then the waypoints."""
        return 1 + len(self._waypoints)

    @property
    def all_requirements(self) -> tuple[Requirement, ...]:
        """Path constraints, goals and waypoints, as far as they are plain data."""
        partial = (item.required for item in self.partial if isinstance(item.required, Requirement))
        return (*self.requirements, *partial, *self.goals, *chain(*self.waypoint_requirements))

    @property
    def residual_constraints(self) -> tuple[Constraint, ...]:
        """What must hold all the way and is code, so that the judge samples it."""
        return tuple(item for item in self.constraints if isinstance(item, Constraint))

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """What must hold all the way and is plain data, so that the judge can prove it."""
        return tuple(item for item in self.constraints if isinstance(item, Requirement))

    def _check_names(self, item: PathConstraint | During[PathConstraint]) -> None:
        if isinstance(item, During):
            self._check_names(item.required)
        if isinstance(item, Requirement):
            check_names(self.scene, item)

    @checked
    def save(self, path: Path | str) -> None:
        """Write a bundle, as `Result.save`, of a problem that nobody has planned yet.

        Raises:
            ModelError: If the problem holds code of the caller's, which no file can hold.
            FileFormatError: If the file cannot be written.
        """
        from trajopt.files.bundle import save

        save(self, path)

    def __repr__(self) -> str:
        """Say the problem in a line: robot, group and goal."""
        goal = self.goal if isinstance(self.goal, GoalSet) else " and ".join(map(str, self.goals))
        where = f"{self.scene.robot.name}, group {self.group}"
        return in_short(f"Problem({shown(self.name)}: {where}, to {goal})")

    def __str__(self) -> str:
        """Say the problem in a few lines."""
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

    Names come from the entry-point group `trajopt.problems`, so any package can add some.

    Raises:
        ProblemNotFound: If there is none of that name.
    """
    from importlib.metadata import entry_points

    installed = {entry.name: entry for entry in entry_points(group="trajopt.problems")}
    if str(name) not in installed:
        raise ProblemNotFound("installed problem", name, installed)
    return installed[str(name)].load()()

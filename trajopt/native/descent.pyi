"""Programs over knots, and descents on them; see `trajopt.optimise.solvers.parts`."""

from collections.abc import Callable, Sequence
from enum import Enum

from trajopt.values.arrays import Bools, Floats, Ints

class RobotQuery:
    """Measures distances and places frames; made by the core `proximity`."""

class RobotDynamics:
    """Evaluates torques; made by the core `proximity`."""

class Kind(Enum):
    """The losses of costs."""

    SQUARED = 0
    ABSOLUTE = 1
    HINGE = 2

class Role:
    """What rows are for."""

def cost(kind: Kind, weight: Floats) -> Role: ...
def bounds(lower: Floats, upper: Floats, tolerance: float) -> Role: ...

class Margins:
    """The distance that each pair must keep along a motion."""

    def __init__(self, full: Floats) -> None: ...
    def __call__(self, pair: int, place: float) -> float: ...

def tapered(
    *,
    full: Floats,
    required: Floats,
    at_start: Floats,
    at_end: Floats,
    contact_until: Floats,
    contact_from: Floats,
    depth: Floats,
    gives: Bools,
    last: float,
    taper: float,
    share: float,
) -> Margins: ...

class View:
    """A point of a frame, and the reference that it is seen from."""

    def __init__(
        self,
        *,
        joint: int,
        rotation: Floats,
        point: Floats,
        base: int,
        base_rotation: Floats,
        base_origin: Floats,
    ) -> None: ...

class Shape(Enum):
    """Shapes of regions."""

    BOX = 0
    SPHERE = 1
    CYLINDER = 2
    HALF_SPACE = 3

class FrameTerm:
    """The formula of a term of a frame."""

    @property
    def components(self) -> int: ...

def axis_angle(axis: Floats, direction: Floats, across: Floats) -> FrameTerm: ...
def frame_placement(rotation: Floats, translation: Floats, euler: bool) -> FrameTerm: ...
def point_distance(point: Floats) -> FrameTerm: ...
def view_angle(origin: Floats, axis: Floats, across: Floats) -> FrameTerm: ...
def view_distance(origin: Floats) -> FrameTerm: ...
def region(members: Sequence[tuple[Shape, Floats, Floats, Floats]]) -> FrameTerm: ...

class Point:
    """Everything at one point; never changed."""

    @property
    def x(self) -> Floats: ...
    @property
    def cost(self) -> float: ...
    @property
    def violation(self) -> float: ...
    @property
    def feasible(self) -> bool: ...
    @property
    def kept(self) -> object: ...

class MadeRows:
    """Rows of one part at a point; what is the same at every point is empty."""

    @property
    def value(self) -> Floats: ...
    @property
    def jacobian(self) -> Floats: ...
    @property
    def knots(self) -> Ints: ...
    @property
    def component(self) -> Ints: ...
    @property
    def place(self) -> Floats: ...
    @property
    def weight(self) -> Floats: ...
    @property
    def lower(self) -> Floats: ...
    @property
    def upper(self) -> Floats: ...

class Options:
    """When a descent ends, and how its steps are found."""

    def __init__(
        self,
        *,
        penalty: float,
        relative_gain: float,
        absolute_gain: float,
        accuracy: float,
        regularisation: float,
        qp_iterations: int,
        steps: int,
        failures: int,
        until_feasible: bool,
        window: int,
        violations: list[float],
    ) -> None: ...

Worked = tuple[int, int, int]
"""Configurations, bounds and distances."""

Entry = tuple[float, float, float, float, bool, int, int, Worked]
"""Cost, violation, merit, radius, whether the step was taken, rows, iterations of the QP, work so far."""

InPython = tuple[list[tuple[Floats | Ints, ...]], int, object]
"""Values, derivatives, knots and weights, or lower and upper bounds, of each part that is asked for;
configurations evaluated; and what the point keeps."""

class Program:
    """A program over knots, made of parts."""

    def __init__(self, lower: Floats, upper: Floats, scale: Floats, query: RobotQuery) -> None: ...
    def add_linear(self, role: Role, constant: Floats, jacobian: Floats, knots: Ints) -> None: ...
    def add_distances(
        self,
        role: Role,
        knots: Ints,
        weight: Floats,
        place: Floats,
        reach: Floats,
        factor: Floats,
        margins: Margins,
    ) -> None: ...
    def add_frames(
        self,
        role: Role,
        knots: Ints,
        weight: Floats,
        place: Floats,
        view: View,
        term: FrameTerm,
        configurations: int,
    ) -> None: ...
    def add_distances_in_time(
        self,
        role: Role,
        knots: Ints,
        weight: Floats,
        place: Floats,
        when: Floats,
        driven: Floats,
        among: RobotQuery,
        reach: Floats,
        margin: Floats,
        errors: Floats,
        appears: Floats,
        expires: Floats,
    ) -> None: ...
    def add_torques(
        self,
        role: Role,
        knots: Ints,
        position: Floats,
        velocity: Floats,
        acceleration: Floats,
        place: Floats,
        dynamics: RobotDynamics,
        effort: Floats,
        listed: float,
    ) -> None: ...
    def add_outside(self, role: Role) -> None: ...
    def at(self, x: Floats, ask: Callable[[Floats], InPython]) -> Point: ...
    def rows(self, point: Point, part: int) -> MadeRows: ...
    def descend(
        self,
        start: Point,
        region: Sequence[float],
        failures: int,
        options: Options,
        ask: Callable[[Floats], InPython],
        tell: Callable[[list[Entry]], None],
        seconds: float,
        configurations: int,
    ) -> tuple[int, Point, float, int]: ...
    @property
    def work(self) -> Worked: ...

"""The judge's native core; `trajopt.verify` says what its results mean."""

from trajopt.values.arrays import Bools, Floats, Ints

class Form:
    """A shape with what its support function needs."""

def box(x: float, y: float, z: float, /) -> Form: ...
def round_solid(name: str, radius: float, length: float, /) -> Form: ...
def half_space() -> Form: ...
def hull(vertices: Floats, faces: Ints, /) -> Form: ...
def mesh(vertices: Floats, faces: Ints, hull: Form, representatives: Floats, closed: Floats, /) -> Form: ...
def balls(centres: Floats, radius: float, /) -> Form: ...
def cubes(centres: Floats, edge: float, /) -> Form: ...
def largest(times: Floats, coefficients: Floats, sign: float, slack: float, /) -> tuple[Floats, Floats]: ...
def ranges(times: Floats, coefficients: Floats, begin: Floats, end: Floats, /) -> tuple[Floats, Floats]: ...
def speeds(times: Floats, coefficients: Floats, matrix: Floats, /) -> Floats: ...
def beside(
    times: Floats, coefficients: Floats, other_times: Floats, other_coefficients: Floats, /
) -> tuple[Floats, Floats]: ...
def sampled(coefficients: Floats, piece: Ints, local: Floats, /) -> Floats: ...
def limits_hold(
    times: Floats,
    coefficients: Floats,
    low: Floats,
    high: Floats,
    before: Floats,
    most: Floats,
    rests_after: bool,
    /,
) -> bool: ...

class Arm:
    """The joints of a model."""

    def place(self, positions: Floats, /) -> tuple[Floats, Floats]: ...

def arm(parents: Ints, revolute: Bools, axes: Floats, rotations: Floats, translations: Floats, /) -> Arm: ...

class Dynamics:
    """What the joints of a model carry."""

    def torques(self, q: Floats, v: Floats, a: Floats, /) -> Floats: ...
    def share(
        self,
        times: Floats,
        coefficients: Floats,
        steps: Ints,
        rounding: float,
        rests: Floats,
        expand: Floats,
        offset: Floats,
        effort: Floats,
        /,
    ) -> float: ...

def dynamics(
    arm: Arm, mass: Floats, centre: Floats, inertia: Floats, armature: Floats, gravity: Floats, /
) -> Dynamics: ...

Tallied = tuple[Floats, Floats, Floats]
"""Proven, measured and time of every pair."""

class Proof:
    """Workspace for the distances of the pairs of one reduced model; one for each thread."""

    def __init__(
        self,
        arm: Arm,
        forms: list[Form],
        joint: Ints,
        rotation: Floats,
        translation: Floats,
        first: Ints,
        second: Ints,
        required: Floats,
        errors: Floats,
        listed: Bools,
        error: float,
        /,
    ) -> None: ...
    @property
    def calls(self) -> int: ...
    def measure(
        self, times: Floats, rotation: Floats, translation: Floats, cell: Ints, pair: Ints, /
    ) -> Floats: ...
    def measure_hulls(
        self, times: Floats, rotation: Floats, translation: Floats, cell: Ints, pair: Ints, /
    ) -> Floats: ...
    def search_depths(
        self, times: Floats, rotation: Floats, translation: Floats, cell: Ints, pair: Ints, /
    ) -> Floats: ...
    def nearest(self, times: Floats, rotation: Floats, translation: Floats, strict: Bools, /) -> Floats: ...
    def search(
        self,
        times: Floats,
        coefficients: Floats,
        smooth: bool,
        expand: Floats,
        offset: Floats,
        windowed: Ints,
        windows: Floats,
        edges: Floats,
        options: Floats,
        measured: bool,
        /,
    ) -> tuple[Tallied, Tallied, Floats, tuple[int, float, float], int]: ...

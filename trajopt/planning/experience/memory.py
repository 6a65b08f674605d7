"""Memory: a motion that solved a problem, and what the problem was like."""

from dataclasses import dataclass

from trajopt.values.arrays import Floats, Value


@dataclass(frozen=True, eq=False, kw_only=True)
class Memory(Value):
    """A motion that solved a problem, and what has come of remembering it.

    Attributes:
        number: Its number; numbers are not given again.
        key: What must be the same of another problem: robot, group, and the kinds of what is required.
        start: Where the group's joints were at the start, shape (n,) [rad | m].
        goal: The numbers of the goal: positions, placements, tolerances, shape (g,).
        scene: Where the objects were and how large they are, shape (objects, 6) [m]; see `scene_signature`.
        knots: The path, shape (k, n) [rad | m].
        wins: How often a motion was found from it.
        failures: How often none was, since it last won.
        used: The version of the memory when it was learnt, or last won.
    """

    number: int
    key: str
    start: Floats
    goal: Floats
    scene: Floats
    knots: Floats
    wins: int = 0
    failures: int = 0
    used: int = 0

"""Convex pieces that cover a mesh; see `trajopt.robot.bodies`."""

from numpy import int32
from numpy.typing import NDArray

from trajopt.values.arrays import Floats, Ints

THICKNESS: float
FARTHEST: float

def cover(
    vertices: Floats,
    faces: NDArray[int32],
    parts: NDArray[int32],
    hull_excess: float,
    tolerance: float,
    most_pieces: int,
    samples: int,
    most_work: float,
) -> tuple[Floats, Ints, bool, float, float]: ...

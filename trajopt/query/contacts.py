"""Nearest points of pairs that come near each other."""

from dataclasses import dataclass

from trajopt.arrays import Floats, Ints
from trajopt.values import Value


@dataclass(frozen=True, eq=False)
class Contacts(Value):
    """Nearest points of pairs that come near each other, at many configurations.

    Attributes:
        sample: Configuration of each contact, shape (m,).
        pair: Index of the pair, shape (m,).
        distance: Signed: positive apart, negative in penetration, shape (m,) [m]; inside an exact
            mesh minus the way to its surface.
        normal: Unit vector from the first body to the second, Coal's own (rebuilt from the
            witness points it would flip in penetration), the other way inside an exact mesh, in
            the world, shape (m, 3).
        point_first: Witness point on the first body, in the world, shape (m, 3) [m].
        point_second: Witness point on the second body, in the world, shape (m, 3) [m].
        jacobian: Derivative of the distance by the group's positions, shape (m, n) [m/rad | 1].
    """

    sample: Ints
    pair: Ints
    distance: Floats
    normal: Floats
    point_first: Floats
    point_second: Floats
    jacobian: Floats

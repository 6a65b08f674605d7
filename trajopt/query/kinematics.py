"""Placements and Jacobians of all joints at many configurations at once."""

from dataclasses import dataclass

from trajopt.arrays import Floats, Ints
from trajopt.values import Value


@dataclass(eq=False)
class Counts:
    """Exact numbers of the work done so far; the same on every machine.

    Attributes:
        forward_kinematics: Configurations at which all joints were placed.
        bounds: Spheres tested against boxes, before any distance is asked for.
        distances: Calls of Coal's distance function.
    """

    forward_kinematics: int = 0
    bounds: int = 0
    distances: int = 0


@dataclass(frozen=True, eq=False)
class Kinematics(Value):
    """Joint placements and Jacobians at S configurations of a reduced model with J joints.

    Attributes:
        rotation: Of each joint frame (the world first), shape (S, J, 3, 3).
        translation: Shape (S, J, 3) [m].
        jacobian: Spatial velocity at the world's origin (linear, angular) of each of the group's
            joints at unit speed, shape (S, 6, model joints).
    """

    rotation: Floats
    translation: Floats
    jacobian: Floats

    def take(self, index: Ints) -> "Kinematics":
        """Return the kinematics of some of the configurations."""
        return Kinematics(self.rotation[index], self.translation[index], self.jacobian[index])

"""The fast kernel of proofs: the checks of `trajopt/verify/checker`, in doubles with error bounds."""

from collections.abc import Mapping, Sequence

from trajopt.values.arrays import Floats

class StatedProof:
    """A statement, as JSON is read, with the bytes of its witness."""

    def __init__(self, statement: object, witness: bytes) -> None: ...
    def fault(self) -> str:
        """Return the first part that is not shown; empty if the statement is proven."""

    def leaves(self) -> list[bool]:
        """Return which leaves hold."""

class SweptParts:
    """Balls that contain the parts of a statement in intervals of its motion, and objects at rest."""

    def __init__(
        self, statement: object, times: Sequence[float], frames: Mapping[str, tuple[Floats, Floats]]
    ) -> None:
        """Place the balls.

        Args:
            statement: As JSON is read.
            times: Bounds of intervals, together with the knots of the motion [s].
            frames: Rotations and translations of the frames of objects in the world.
        """

    def keep_apart(self, owner: str, rotation: Floats, translation: Floats) -> bool:
        """Return whether the balls show that an object keeps its clearances if its frame is there."""

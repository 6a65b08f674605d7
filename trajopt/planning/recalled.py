"""Recalled: paths of motions that are remembered, for a problem much like theirs."""

from dataclasses import dataclass

from trajopt.values.arrays import Floats, Value


@dataclass(frozen=True, eq=False)
class Recalled(Value):
    """What was remembered of motions for problems much like one.

    Attributes:
        version: Of the memory: how often it had changed by then.
        memories: The numbers of the memories, the best first.
        seeds: The knots of their paths, shape (k, n) each [rad | m].
    """

    version: int
    memories: tuple[int, ...] = ()
    seeds: tuple[Floats, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold, without the paths."""
        return {"version": self.version, "memories": list(self.memories)}

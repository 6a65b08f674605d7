"""Arguments of a call of planning other than the problem, so that the call can be repeated."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trajopt.optimise.methods import Method
from trajopt.planning.budget import Budget
from trajopt.values.arrays import Floats, Value
from trajopt.values.errors import ProblemError, shown


@dataclass(frozen=True, eq=False)
class Recalled(Value):
    """Remembered motions of similar problems.

    Attributes:
        version: Of the memory: the number of its changes by then.
        memories: Their numbers, the best first.
        seeds: The knots of their paths, shape (k, n) each [rad | m].
    """

    version: int
    memories: tuple[int, ...] = ()
    seeds: tuple[Floats, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain data that JSON can hold, without the paths."""
        return {"version": self.version, "memories": list(self.memories)}


@dataclass(frozen=True, eq=False)
class PlanArguments(Value):
    """Arguments of planning.

    Attributes:
        method: As `plan` takes it: a method, its name, or None.
        improve: Whether a motion faster than along the path was looked for.
        every_goal: Whether all goals of a set were planned to.
        random: The state of the given generator before planning; None without.
        seeds: Knots of the given or remembered paths, shape (k, n) each [rad | m].
        recalled: The remembered motions and the version of the memory; None without experience. Its
            paths are the last of `seeds`, so that planning again needs no memory.
    """

    method: Method | str | None = None
    improve: bool = False
    every_goal: bool = False
    budget: Budget = field(default_factory=Budget)
    random: Mapping[str, Any] | None = None
    seeds: tuple[Floats, ...] = ()
    recalled: Recalled | None = None

    @staticmethod
    def of(
        method: Method | str | None,
        improve: bool,
        every_goal: bool,
        budget: Budget,
        rng: np.random.Generator | None,
        seeds: tuple[Floats, ...],
        recalled: Recalled | None = None,
    ) -> "PlanArguments":
        """Keep the arguments of a call that has not yet drawn from its generator."""
        state = None if rng is None else rng.bit_generator.state
        return PlanArguments(method, improve, every_goal, budget, state, seeds, recalled)

    @property
    def generator(self) -> np.random.Generator | None:
        """A generator in the state of the given one; None without."""
        if self.random is None:
            return None
        name = self.random.get("bit_generator")
        kind = {each.__name__: each for each in _GENERATORS}.get(str(name))
        if kind is None:
            raise ProblemError(f"no kind of random generator is called {shown(name)}")
        bits: Any = kind()
        try:
            bits.state = dict(self.random)
        except (TypeError, ValueError, KeyError) as error:
            raise ProblemError(f"the state of the random generator is none: {error}") from error
        return np.random.Generator(bits)

    @property
    def repeatable(self) -> bool:
        """Whether planning again must end the same: no clock had a part in it."""
        return self.budget.seconds is None


_GENERATORS = (np.random.PCG64, np.random.PCG64DXSM, np.random.MT19937, np.random.Philox, np.random.SFC64)

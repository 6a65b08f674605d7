"""When a requirement has to hold, and a check that says whether it does."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.printed import in_unit_apart
from trajopt.verify.certificate import Check, Evidence
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.search.interval_proof import Proof


class When(Enum):
    """When a requirement has to hold."""

    END = "goal"
    ALWAYS = "path"


@dataclass(frozen=True, eq=False)
class Component:
    """One number of a requirement at its tightest moment.

    Attributes:
        name: Which number, as words.
        value: Its size [unit].
        tolerance: Its largest accepted size [unit].
    """

    name: str
    value: float
    tolerance: float


def tightest(names: tuple[str, ...], values: Floats, tolerances: Floats) -> Component:
    """Return the number that is nearest to, or farthest beyond, its tolerance."""
    at = int(np.argmax(values - tolerances))
    return Component(names[at], float(values[at]), float(tolerances[at]))


def requirement_check(
    when: When,
    *,
    kind: str,
    subject: str,
    unit: str,
    component: Component,
    proof: Proof,
) -> Check:
    """State a requirement whose numbers must stay below tolerances as a check.

    Args:
        when: When it has to hold.
        kind: What is required, such as "position".
        subject: The frame.
        unit: Unit of the number.
        component: The tightest number at the tightest time.
        proof: What is known of all times.
    """
    here, accepted = in_unit_apart(component.value, component.tolerance, unit)
    many = f"{component.name} is {here}, {accepted} is accepted"
    if proof.interval is not None:
        many += f"; no proof from {proof.interval[0]:.5f} to {proof.interval[1]:.5f} s"
    return Check(
        name=f"{when.value}: {kind}",
        subject=subject,
        value=component.value,
        bound=component.tolerance,
        unit=unit,
        time=proof.time,
        slack=component.tolerance - component.value,
        evidence=proof.evidence,
        holds=proof.evidence is Evidence.PROVEN,
        detail=many,
    )


def proof_at_end(motion: Motion, excess: float) -> Proof:
    """State what the excess at the end proves."""
    evidence = Evidence.PROVEN if excess <= motion.options.excess else Evidence.SAMPLED
    return Proof(evidence, motion.duration, None)

"""Check a proof file: `python -I trajopt/verify/checker x.proof`.

Exit status 0: the statement is proven; 1: it is not; 2: the file is not a proof of the format.
"""

import sys
from itertools import chain
from pathlib import Path

import clearance
import limits
import numpy as np
from kinematics import GridKinematics
from reading import Malformed, demand, open_file
from rule_kinds import read_requirement
from statement import Change, Statement, read_statement
from witness import read_witness


def examined(path: Path) -> tuple[str, str]:
    """Return the statement of a file in words, and the first fault; an empty one if it is proven."""
    found, data = open_file(path)
    statement = read_statement(found)
    requirements = [read_requirement(each, statement) for each in statement.requirements]
    witness = read_witness(data, statement)
    with np.errstate(all="ignore"):  # a number that is not finite fails the comparison that it reaches
        arm = GridKinematics(statement, witness.grid)
        faults = chain(
            limits.check(statement, arm),
            (fault for each in requirements for fault in arm.unshown(each.holds(arm), each.words)),
            clearance.check(statement, witness, arm),
        )
        return in_words(statement, [each.words for each in requirements]), next(faults, "")


def in_words(statement: Statement, rules: list[str]) -> str:
    """Return a statement in sentences."""
    levels = [f"{1e3 * level:g} mm" for level in sorted({level for _, _, level in statement.pairs} or {0.0})]
    kept = " or ".join(levels if len(levels) < 5 else [f"{levels[0]} to {levels[-1]} (each pair its own)"])
    ends, names = statement.ends, ", ".join(statement.motion.coordinates)
    stated = [
        f"{sum(getattr(each, kind) < np.inf for each in statement.joints)} {kind}" for kind in limits.KINDS
    ]
    lines = [
        f"{statement.title}: for all t in [0, {statement.motion.times[-1]:.6g} s]",
        f"  {len(statement.pairs)} pairs of {len(statement.parts)} convex parts keep more than {kept} apart:"
        f" all that {names} can move, but {len(statement.excused)} excused pairs of owners",
        *(f"    {one} and {other}: {reason}" for one, other, reason in statement.excused),
        *(f"  {_in_words(change)}" for change in statement.changes),
        *(f"  {a} and {b} may touch outside [{x:g}, {y:g}] s" for a, b, x, y in statement.contacts),
        f"  {len(statement.joints)} joints keep their limits: {', '.join(stated)}",
        f"  limits and requirements hold to within {statement.excess:g}",
        f"  the motion has the stated start, to within {ends.tolerance:g}"
        f"{', and ends at rest' * ends.rests}; speeds are to within {ends.speed:g}",
        *(f"  {rule}" for rule in rules),
        *(f"  judged, not part of this proof: {each}" for each in statement.judged),
    ]
    return "\n".join(lines)


def _in_words(change: Change) -> str:
    r, v, a = change.error
    span = f"from {change.appears:g} to {change.expires:g} s"
    return f"{change.owner} is there {span}, within {r:g} + {v:g} t + {a / 2.0:g} t^2 m of its stated place"


def main(arguments: list[str]) -> int:
    """Check the file that is named; return the exit status."""
    try:
        demand(len(arguments) == 1, "usage: python -I checker FILE.proof")
        words, fault = examined(Path(arguments[0]))
    except Malformed as error:
        sys.stderr.write(f"{error}\n")
        return 2
    sys.stdout.write(f"{words}\n{'NOT PROVEN: ' + fault if fault else 'PROVEN'}\n")
    return 1 if fault else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

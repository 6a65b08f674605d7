"""Arguments of the warehouse that are right, by "function.argument"."""

from typing import Any

from trajopt.problem.requirements import Requirement
from trajopt.server.warehouse import Warehouse


def samples_of_the_warehouse(goal: Requirement) -> dict[str, Any]:
    """Return them."""
    return {
        "Warehouse.copy_to.other": object.__new__(Warehouse),
        "StoredState.positions": {"joint1": 0.1},
        "Constraints.requirements": (goal,),
    }

"""What every server can do."""

from collections.abc import Mapping

from trajopt.server.operation import Operation
from trajopt.server.operations.planning import plan_request

OPERATIONS: Mapping[str, Operation] = {
    "plan_request": Operation(plan_request),
}
"""What can be asked for, by name."""

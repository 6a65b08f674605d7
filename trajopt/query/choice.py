"""Which body answers: the compiled one where it is installed."""

from trajopt.model.reduced import ReducedModel
from trajopt.native import installed
from trajopt.query.kinematics import Counts
from trajopt.query.plain import PlainQuery
from trajopt.query.query import Query


def query_of(reduced: ReducedModel, counts: Counts | None = None) -> Query:
    """Return a query of a reduced model; both bodies answer the same.

    Args:
        reduced: The robot and its surroundings.
        counts: Takes the work done; counts of its own when None.
    """
    if not installed("proximity"):
        return PlainQuery(reduced, counts)
    from trajopt.query.compiled import CompiledQuery

    return CompiledQuery(reduced, counts)

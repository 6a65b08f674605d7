"""The two bodies of the judge's kinematics, distances and search, and the choice between them."""

from collections.abc import Callable
from dataclasses import dataclass

from trajopt.model.reduced import ReducedModel
from trajopt.verify.kernel.body import Body
from trajopt.verify.kernel.distances import Distances
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import Motion
from trajopt.verify.kernel.pair_distances import PairDistances
from trajopt.verify.search.clearance_record import Findings
from trajopt.verify.search.clearance_search import ClearanceSearch


@dataclass(frozen=True, eq=False)
class Workspace:
    """What a judge computes with; one for each thread.

    Attributes:
        body: Which body it is.
        kinematics: Forward kinematics of the model.
        distances: Distances of its bodies.
        search: Searches for a proof that they keep apart over a motion.
    """

    body: Body
    kinematics: Kinematics
    distances: PairDistances
    search: Callable[[Motion], Findings]


def workspace(reduced: ReducedModel, body: Body, *, error: float) -> Workspace:
    """Build the kinematics and geometry of a model.

    Args:
        reduced: The model.
        body: Which body to use; the native one must be installed.
        error: Taken off every distance [m].

    Raises:
        ModelError: If two half-spaces have to keep apart.
    """
    if body is Body.PYTHON:
        plain = Distances(reduced, error=error)
        return Workspace(
            body, Kinematics(reduced), plain, lambda motion: ClearanceSearch(motion, plain).run()
        )
    from trajopt.verify.kernel.native_distances import NativeDistances
    from trajopt.verify.kernel.native_kinematics import NativeKinematics

    kinematics = NativeKinematics(reduced)
    distances = NativeDistances(kinematics, error=error)
    return Workspace(body, kinematics, distances, distances.search)

"""An executor without physics: the smallest thing that keeps the protocol."""

from trajopt.arrays import Floats
from trajopt.model.reduced import ReducedModel
from trajopt.model.trajectory import Trajectory


class JumpingExecutor:
    """Is at the end of a trajectory at once, or short of it by a given amount in every joint."""

    def __init__(self, positions: Floats, *, short_by: float = 0.0) -> None:
        self.at = positions
        self.followed: list[Trajectory] = []
        self._short_by = short_by

    def positions(self) -> Floats:
        return self.at

    def start(self, reduced: ReducedModel, trajectory: Trajectory) -> None:
        self.followed.append(trajectory)
        self.at = reduced.all_positions(trajectory.positions[-1] - self._short_by)

    def moving(self) -> bool:
        return False

    def wait(self) -> str:
        return ""

    def stop(self) -> None:
        pass

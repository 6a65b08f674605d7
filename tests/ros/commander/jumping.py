"""An executor that takes no time: it is at the end of a motion at once."""

from trajopt.driving import CommittedMotion, IdealExecutor
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory

JOINTS = ("shoulder", "elbow", "wrist")


class JumpingExecutor(IdealExecutor):
    """Is at the end of a trajectory at once, or short of it by a given amount in every joint."""

    def __init__(self, positions: Floats, *, short_by: float = 0.0) -> None:
        super().__init__(JOINTS, positions)
        self.followed: list[Trajectory] = []
        self._short_by = short_by

    def splice(self, trajectory: Trajectory, at: float) -> str:
        refused = super().splice(trajectory, at)
        if not refused:
            self.followed.append(trajectory)
            self.advance(self.committed.end - self.now() + 1.0)
            self.displace(self._displaced - self._short_by)
        return refused

    def stand_at(self, positions: Floats) -> None:
        self.committed = CommittedMotion(JOINTS, positions)

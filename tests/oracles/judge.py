"""The judge in plain Python."""

import numpy as np
import pinocchio as pin

from tests.oracles.judge_distances import PlainDistances
from tests.oracles.judge_search import PlainSearch
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats
from trajopt.verify import Judge, VerifyOptions
from trajopt.verify.kernel.clearance_search import Findings
from trajopt.verify.kernel.kinematics import Kinematics, Poses
from trajopt.verify.kernel.motion import JudgedMotion


class PlainKinematics(Kinematics):
    """One configuration after the other, by pinocchio's own binding."""

    def __init__(self, reduced: ReducedModel) -> None:
        super().__init__(reduced)
        self._data = reduced.model.createData()

    def poses(self, positions: Floats) -> Poses:
        model, data, configurations = self.reduced.model, self._data, self.configurations(positions)
        matrices = np.empty((len(positions), len(self.parents), 4, 4))
        for row, configuration in enumerate(configurations):
            pin.forwardKinematics(model, data, configuration)
            matrices[row] = [placement.np for placement in data.oMi.tolist()]
        self.calls += len(positions)
        return Poses(configurations, matrices[..., :3, :3], matrices[..., :3, 3])

    def torques(self, positions: Floats, velocities: Floats, accelerations: Floats) -> Floats:
        rows = zip(self.configurations(positions), velocities, accelerations, strict=True)
        return np.array([pin.rnea(self.reduced.model, self._data, q, v, a) for q, v, a in rows])


class PlainJudge(Judge):
    """A judge whose kinematics, distances and search are plain Python."""

    def __init__(self, reduced: ReducedModel, options: VerifyOptions | None = None) -> None:
        options = options or VerifyOptions()
        super().__init__(reduced, options)
        self._kinematics = PlainKinematics(reduced)
        self._distances = self._plain = PlainDistances(reduced, error=options.distance_error)

    def _search(self, motion: JudgedMotion, *, measured: bool) -> Findings:
        del measured
        return PlainSearch(motion, self._plain).run()

"""A picture's model, put into any moment of a motion, and the lines that a picture shows of it."""

from collections.abc import Iterable

import numpy as np

from trajopt.arrays import Floats
from trajopt.io.engine import mujoco
from trajopt.model.reduced import ReducedModel, tool_frames, tool_point
from trajopt.simulate.motion import Motion
from trajopt.simulate.spec import scalar_first
from trajopt.simulate.stage import picture_spec

PATH_POINTS = 61
"""Points of the line that a tool draws."""


class PosedModel:
    """MuJoCo's model of robot and scene for pictures, at one moment of a motion.

    Attributes:
        model: The compiled model.
        data: Where everything is at the moment.
        owners: The object that a geometry belongs to, by the geometry's number; of those that nothing moves.
        motion: The motion.
        paths: Where each tool of the group goes, shape (tools, PATH_POINTS, 3) in the world [m].
    """

    def __init__(
        self,
        reduced: ReducedModel,
        motion: Motion,
        shown: Floats,
        highlight: Iterable[str] = (),
    ) -> None:
        """Compile the model.

        Args:
            reduced: Robot and scene.
            motion: What will be shown.
            shown: Points around everything that will be in view, shape (k, 3) in the world [m].
            highlight: Links and objects that are drawn in a colour of their own.
        """
        self._reduced, self.motion = reduced, motion
        picture = picture_spec(reduced, shown, loose=motion.loose, highlight=frozenset(highlight))
        self.model = picture.spec.compile()
        self.data = mujoco.MjData(self.model)
        self.owners = {self.model.geom(name).id: owner for name, owner in picture.owners.items()}
        names = tuple(reduced.model.names[1:])
        self._address = [self.model.jnt_qposadr[self.model.joint(name).id] for name in names]
        self._bodies = [int(self.model.jnt_bodyid[self.model.joint(name).id]) for name in names]
        self.paths = tool_paths(reduced, motion)

    def pose(self, t: float) -> None:
        """Put everything where it is at a time [s]."""
        reduced = self._reduced
        if self.motion.loose:
            where = self.motion.loose_at(t)
            self.data.mocap_pos[0], self.data.mocap_quat[0] = where.translation, scalar_first(where)
        self.data.qpos[self._address] = reduced.mimic_matrix @ self.motion(t) + reduced.mimic_offset
        mujoco.mj_kinematics(self.model, self.data)

    def skeleton(self) -> Floats:
        """Return the lines from joint to joint of what moves, at the moment, shape (k, 2, 3) [m]."""
        parents = self.model.body_parentid[self._bodies]
        inner = parents > 0
        ends = self.data.xpos[np.array(self._bodies)[inner]]
        return np.stack((self.data.xpos[parents[inner]], ends), axis=1)


def tool_paths(reduced: ReducedModel, motion: Motion) -> Floats:
    """Return where each tool of the group goes, shape (tools, PATH_POINTS, 3) in the world [m]."""
    along = [motion(t) for t in np.linspace(0.0, motion.duration, PATH_POINTS)]
    return np.array([[tool_point(reduced, tool, at) for at in along] for tool in tool_frames(reduced)])

"""A picture's model, put into any moment of a motion, and the lines that a picture shows of it."""

from collections.abc import Iterable, Mapping
from typing import TypeVar

import numpy as np

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.reduced import ReducedModel, tool_frames, tool_point
from trajopt.simulation.halo import THINNEST
from trajopt.simulation.motion import Motion
from trajopt.simulation.pieces import scalar_first
from trajopt.simulation.stage import HALO_GROUP, UNSEEN_GROUP, picture_spec
from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement, from_quaternion

T = TypeVar("T")
PATH_POINTS = 61
"""Points of the line that a tool draws."""


class PosedModel:
    """MuJoCo's model of robot and scene for pictures, at one moment of a motion.

    Attributes:
        model: The compiled model.
        data: Where everything is at the moment.
        owners: The object that a geometry belongs to, by the geometry's number; of those that the robot does
            not move.
        changing: What changes with time.
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
        self.owners = self._numbered(picture.owners)
        self.changing = picture.changing
        self._coming = self._numbered(picture.coming)
        self._group = {geom: int(self.model.geom_group[geom]) for geom in self._coming}
        self._halos = self._numbered(picture.halos)
        names = tuple(reduced.model.names[1:])
        self._address = [self.model.jnt_qposadr[self.model.joint(name).id] for name in names]
        self._bodies = [int(self.model.jnt_bodyid[self.model.joint(name).id]) for name in names]
        self.paths = tool_paths(reduced, motion)

    def pose(self, t: float) -> None:
        """Put everything where it is at a time [s]."""
        reduced, changing, data = self._reduced, self.changing, self.data
        if self.motion.loose:
            where, place = self.motion.loose_at(t), int(self.model.body(self.motion.loose).mocapid[0])
            data.mocap_pos[place], data.mocap_quat[place] = where.translation, scalar_first(where)
        changing.put(self.model, data, t)
        for geom, owner in self._coming.items():
            self.model.geom_group[geom] = self._group[geom] if changing.there(owner, t) else UNSEEN_GROUP
        for geom, (owner, _) in self._halos.items():
            seen = changing.there(owner, t) and changing.error(owner, t) > THINNEST
            self.model.geom_group[geom] = HALO_GROUP if seen else UNSEEN_GROUP
        self.data.qpos[self._address] = reduced.mimic_matrix @ self.motion(t) + reduced.mimic_offset
        mujoco.mj_kinematics(self.model, self.data)

    def grow_halos(self, t: float) -> tuple[int, ...]:
        """Give halos their size at a time [s]; return the meshes that have changed, to be drawn anew."""
        model = self.model
        meshes: list[int] = []
        for geom, (owner, halo) in self._halos.items():
            mesh = int(model.geom_dataid[geom])
            begin, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            w, x, y, z = model.mesh_quat[mesh].tolist()
            own = Placement(from_quaternion(x, y, z, w), model.mesh_pos[mesh]).inverse()
            model.mesh_vert[begin : begin + count] = own * halo.grown(self.changing.error(owner, t))
            meshes.append(mesh)
        return tuple(meshes)

    def skeleton(self) -> Floats:
        """Return the lines from joint to joint of what moves, at the moment, shape (k, 2, 3) [m]."""
        parents = self.model.body_parentid[self._bodies]
        inner = parents > 0
        ends = self.data.xpos[np.array(self._bodies)[inner]]
        return np.stack((self.data.xpos[parents[inner]], ends), axis=1)

    def _numbered(self, named: Mapping[str, T]) -> dict[int, T]:
        return {self.model.geom(name).id: value for name, value in named.items()}


def tool_paths(reduced: ReducedModel, motion: Motion) -> Floats:
    """Return where each tool of the group goes, shape (tools, PATH_POINTS, 3) in the world [m]."""
    along = [motion(t) for t in np.linspace(0.0, motion.duration, PATH_POINTS)]
    return np.array([[tool_point(reduced, tool, at) for at in along] for tool in tool_frames(reduced)])

"""Depths drawn by MuJoCo: robot and objects as a depth camera has them in view."""

import numpy as np

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.camera import Camera, Singles
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.camera import visible_points
from trajopt.simulation.offscreen import Offscreen
from trajopt.simulation.pieces import scalar_first
from trajopt.simulation.stage import FLOOR_GROUP, HALO_GROUP, UNSEEN_GROUP, picture_spec
from trajopt.values.arrays import Floats
from trajopt.values.placement import Placement, placement

OPTICAL_TO_MUJOCO = placement(rpy=(np.pi, 0.0, 0.0))
"""MuJoCo's cameras look along -z, with y up; an optical frame has z forward and y down."""
NAME = "depth camera"
NEARER = 0.5
"""What is nearer than this share of the nearest depth is not drawn: it would be cut open otherwise."""


class DrawnDepth:
    """A model and the context that it is drawn in.

    Attributes:
        fixed: Positions of the joints that it does not move [rad | m].
        screen: The context.
    """

    def __init__(self, reduced: ReducedModel, camera: Camera, fixed: Floats) -> None:
        """Compile the model.

        Args:
            reduced: Robot and scene.
            camera: The camera.
            fixed: Positions of the joints that the group does not move.

        Raises:
            RenderingUnavailable: If no OpenGL works here.
        """
        lens = camera.intrinsics
        shown = visible_points(reduced, reduced.start_positions[None])
        spec = picture_spec(reduced, shown).spec
        spec.visual.quality.offsamples = 0  # depths between a thing and what is behind it are neither's
        spec.visual.map.znear = NEARER * camera.nearest / spec.stat.extent
        spec.visual.map.zfar = (camera.farthest + camera.nearest) / spec.stat.extent
        spec.visual.global_.offwidth, spec.visual.global_.offheight = lens.width, lens.height
        eye = spec.worldbody.add_camera(name=NAME)
        eye.resolution = np.array((lens.width, lens.height))
        eye.sensor_size = np.array((lens.width, lens.height)) * 1e-6
        eye.focal_pixel = np.array((lens.fx, lens.fy))
        # MuJoCo has it from the axis to the middle of the picture, to the left and up.
        eye.principal_pixel = np.array(((lens.width - 1) / 2 - lens.cx, (lens.height - 1) / 2 - lens.cy))
        self.fixed = fixed
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.options = mujoco.MjvOption()
        for group in (FLOOR_GROUP, HALO_GROUP, UNSEEN_GROUP):
            self.options.geomgroup[group] = 0
        self.view = mujoco.MjvCamera()
        self.view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self.view.fixedcamid = self.model.camera(NAME).id
        self.scene = mujoco.MjvScene(self.model, self.model.ngeom + 1)
        names = tuple(reduced.model.names[1:])
        self.address = [self.model.jnt_qposadr[self.model.joint(name).id] for name in names]
        self.screen = Offscreen(self.model, lens.width, lens.height)

    def depth(self, reduced: ReducedModel, where: Placement) -> Singles:
        """Return the depths of robot and objects where the group starts, seen from an optical frame."""
        eye = where * OPTICAL_TO_MUJOCO
        place = self.view.fixedcamid
        self.model.cam_pos[place], self.model.cam_quat[place] = eye.translation, scalar_first(eye)
        moved = reduced.mimic_matrix @ reduced.start_positions + reduced.mimic_offset
        self.data.qpos[self.address] = moved
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self.model, self.data, self.options, None, self.view, everything, self.scene)
        extent, planes = self.model.stat.extent, self.model.vis.map
        return self.screen.depth(self.scene, planes.znear * extent, planes.zfar * extent)

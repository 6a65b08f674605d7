"""The simulated robot: model and state of MuJoCo, in the joint order of Pinocchio."""

from collections.abc import Mapping

import numpy as np

from trajopt.robot.loading.mujoco_library import mujoco
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.dynamic_scene import Presence
from trajopt.simulation.spec import SpecReport, describe
from trajopt.values.arrays import Floats, readonly
from trajopt.values.errors import ModelError, shown
from trajopt.values.placement import Placement, from_quaternion

SMALLEST_MOVED_INERTIA = 1e-9
"""Least inertia of a joint that can be simulated [kg m^2 | kg]."""
HELD = 1e6
"""Damping of a held joint: no motor moves it by a micrometre in a second [Nm s/rad | N s/m]."""
TOUCH_DEPTH = 1e-6
"""Penetration up to this is rounding of the single-precision meshes of MuJoCo, not a contact [m]."""


class Plant:
    """Model and state of MuJoCo for a reduced model; one per simulation."""

    def __init__(self, reduced: ReducedModel, dt: float, report: SpecReport | None = None) -> None:
        report = report or describe(reduced)
        report.spec.option.timestep = dt
        # A diverged simulation is reported; by default MuJoCo resets it silently.
        report.spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET.value
        try:
            self.model = report.spec.compile()
        except ValueError as error:
            raise ModelError(f"MuJoCo rejects the model: {error}") from error
        self.data = mujoco.MjData(self.model)
        self.notes = report.notes
        names = tuple(reduced.model.names[1:])
        joints = [self.model.joint(name).id for name in names]
        self._position = self.model.jnt_qposadr[joints]
        self._velocity = self.model.jnt_dofadr[joints]
        self._owner = [report.owners.get(self.model.geom(i).name, "") for i in range(self.model.ngeom)]
        self._changing = report.changing
        self._presence = Presence(report.changing, self.model, self._owner)
        self._mimic_matrix, self._mimic_offset = reduced.mimic_matrix, reduced.mimic_offset
        self.reset(reduced.start_positions, np.zeros(len(reduced.joint_names)))
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        moved = np.diag(self._mimic_matrix.T @ full[self._velocity][:, self._velocity] @ self._mimic_matrix)
        light = np.flatnonzero(moved < SMALLEST_MOVED_INERTIA)
        self.massless = reduced.joint_names[int(light[0])] if len(light) else ""

    @property
    def positions(self) -> Floats:
        return self.data.qpos[self._position]

    @property
    def velocities(self) -> Floats:
        """Velocities of the model's joints, in the order of Pinocchio [rad/s | m/s]."""
        return self.data.qvel[self._velocity]

    def placement_of(self, loose: str) -> Placement:
        """Return the placement of a loose object by its free joint (its body lags by a step)."""
        place = self.model.jnt_qposadr[self.model.joint(loose).id]
        x, y, z, w, qx, qy, qz = self.data.qpos[place : place + 7].tolist()
        return Placement(readonly(from_quaternion(qx, qy, qz, w)), readonly(np.array((x, y, z))))

    def reset(self, positions: Floats, velocities: Floats) -> None:
        mujoco.mj_resetData(self.model, self.data)
        self.show(0.0, positions, velocities)

    def step(self, torques: Floats) -> Mapping[tuple[str, str], float]:
        """Advance one time step; return the penetration [m] before the step, by pair of owners."""
        self.data.ctrl[:] = torques
        self._put(self.data.time)
        mujoco.mj_step(self.model, self.data)
        return self._touching()

    def hold(self, joint: str, *, held: bool) -> None:
        place = self.model.jnt_dofadr[self.model.joint(joint).id]
        self.model.dof_damping[place] = HELD if held else 0.0

    def _put(self, time: float) -> None:
        self._changing.put(self.model, self.data, time)
        self._presence.show(time)

    def _touching(self) -> Mapping[tuple[str, str], float]:
        depths: dict[tuple[str, str], float] = {}
        if self.data.ncon == 0:
            return depths
        contacts = self.data.contact
        for k in np.flatnonzero(contacts.dist < -TOUCH_DEPTH).tolist():
            first, second = (self._owner[int(geom)] for geom in contacts.geom[k])
            pair = (min(first, second), max(first, second))
            depths[pair] = max(depths.get(pair, 0.0), -float(contacts.dist[k]))
        return depths

    def require_masses(self) -> None:
        if self.massless:
            raise ModelError(
                f"joint {shown(self.massless)} moves no mass, so dynamics cannot be simulated; "
                "add <inertial> to the links beyond it in the URDF"
            )

    def show(self, time: float, positions: Floats, velocities: Floats) -> Mapping[tuple[str, str], float]:
        """Set positions and velocities of the group (n,) at a time [s]; return penetrations [m] by owners."""
        self.data.qpos[self._position] = self._mimic_matrix @ positions + self._mimic_offset
        self.data.qvel[self._velocity] = self._mimic_matrix @ velocities
        self._put(time)
        mujoco.mj_forward(self.model, self.data)
        return self._touching()

"""Small robots for the judge's tests, written to URDF files."""

from pathlib import Path

import numpy as np

from trajopt.robot.robot import Robot
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.trajectory import Trajectory

INERTIA = """<inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>"""


def link(name: str, *, length: float = 0.0, mass: float = 1.0) -> str:
    """A link; with a length it is a thin rod (a box) along x from its joint."""
    body = INERTIA.format(x=length / 2, mass=mass)
    if length:
        body += f"""<collision><origin xyz="{length / 2} 0 0"/><geometry>
        <box size="{length} 0.02 0.02"/></geometry></collision>"""
    return f'<link name="{name}">{body}</link>'


def joint(
    name: str,
    parent: str,
    child: str,
    *,
    kind: str = "revolute",
    x: float = 0.0,
    axis: str = "0 0 1",
    extra: str = "",
) -> str:
    bounds = "" if kind == "fixed" else '<limit lower="-3" upper="3" velocity="20" effort="500"/>'
    return f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{x} 0 0"/><axis xyz="{axis}"/>{bounds}{extra}</joint>"""


def robot(folder: Path, *parts: str) -> Robot:
    path = folder / "arm.urdf"
    path.write_text('<robot name="arm">' + "".join(parts) + "</robot>")
    return Robot.from_urdf(path)


def planar_arm(folder: Path, *, axis: str = "0 0 1") -> Robot:
    """Two rods of 0.5 m in the plane z = 0, turning about `axis`; 'tip' is the end of the second."""
    return robot(
        folder,
        link("base"),
        link("upper", length=0.5),
        link("lower", length=0.5),
        link("tip", mass=0.01),
        joint("shoulder", "base", "upper", axis=axis),
        joint("elbow", "upper", "lower", x=0.5, axis=axis),
        joint("end", "lower", "tip", kind="fixed", x=0.5),
    )


def mixed_arm(folder: Path) -> Robot:
    """Revolute, continuous and prismatic joints about skew axes, and a mimicking finger."""
    return robot(
        folder,
        link("base"),
        link("a", length=0.3),
        link("b", length=0.4),
        link("c", length=0.2),
        link("d", length=0.3),
        link("finger", length=0.1),
        joint("j1", "base", "a", axis="0 0.6 0.8"),
        joint("j2", "a", "b", kind="continuous", x=0.3, axis="0 1 0"),
        joint("j3", "b", "c", kind="prismatic", x=0.4, axis="1 0 0"),
        joint("j4", "c", "d", x=0.2, axis="0.48 0.6 0.64"),
        joint("j5", "d", "finger", x=0.3, extra='<mimic joint="j4" multiplier="-0.5" offset="0.1"/>'),
    )


def reduced(scene: Scene, start: Floats | list[float]) -> ReducedModel:
    """The model of all joints, starting at given positions of the group's."""
    arm = scene.robot
    values = dict(zip(arm.group("all").joints, start, strict=True))
    return reduce_model(scene, "all", arm.positions(values))


def quintic(model: ReducedModel, knots: Floats | list[list[float]], duration: float) -> Trajectory:
    """Stand still at every knot on the way, each leg a minimum-jerk polynomial."""
    positions = np.asarray(knots, dtype=float)
    rest = np.zeros_like(positions)
    times = np.linspace(0.0, duration, len(positions))
    return Trajectory(model.joint_names, times, positions, rest, rest)


def wavy(
    model: ReducedModel, seed: int, *, legs: int = 4, size: float = 0.8, duration: float = 2.0
) -> Trajectory:
    """A random cubic trajectory from the model's start, at rest at both ends."""
    rng = np.random.default_rng(seed)
    count = len(model.joint_names)
    positions = np.vstack((np.zeros(count), rng.uniform(-size, size, (legs, count)))) + model.start_positions
    velocities = rng.uniform(-size, size, (legs + 1, count))
    velocities[[0, -1]] = 0.0
    return Trajectory(model.joint_names, np.linspace(0.0, duration, legs + 1), positions, velocities)

"""Process paths: rows on a wall with arm and base, and a raster and seams on the mesh of a part.

python -m benchmarks.process_paths [--page FILE]
"""

import argparse
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from trajopt_robots._example_robot_data import share_folder

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.problem.requirements import FollowsCurve
from trajopt.tasks import FollowCurve, Task
from trajopt.tasks.cartesian import Begin, Curve, FollowOptions, arc_about, follow, polyline, raster
from trajopt.values.shapes.mesh import load_mesh
from trajopt.verify.certificate import Certificate, Evidence

BAND = 0.02
"""Accepted deviation from the speed."""
PART = "example-robot-data/robots/ur_description/meshes/ur5/collision/base.stl"
"""The foot of a UR5 as a part, enlarged by a half."""
PANDA = "example-robot-data/robots/panda_description"
RIM, TILT = 0.17, np.radians(30.0)
"""Radius of the seams on the table around the part [m]; tilt of the torch [rad]."""


@dataclass(frozen=True, eq=False)
class Process:
    """Curves of a tool.

    Attributes:
        start: State of the robot before.
        speed: Of the tool [m/s].
        cone: Tilt of the tool from z of a pose, which it may use [rad].
        off: Length of the straight motions before and after each curve [m].
    """

    name: str
    scene: to.Scene
    group: str
    start: str | Mapping[str, float]
    tool: str
    curves: Sequence[Curve]
    speed: float
    cone: float = np.radians(0.1)
    off: float = 0.03

    @property
    def options(self) -> FollowOptions:
        """Return the options of all curves."""
        drop = 1.0 - (1.0 - BAND) / (1.0 + BAND)
        steady = to.tool_speed(self.tool, linear=(1.0 + BAND) * self.speed, steady=drop)
        return FollowOptions(begin=Begin.ANY_BRANCH, tool_speed=(steady,))

    def required(self, curve: Curve) -> FollowsCurve:
        """Return the requirement of a curve: 0.1 mm, with free spin."""
        return to.follows_curve(self.tool, curve, spin=(0, 0, 1), rotation_tolerance=self.cone)

    def task(self) -> Task:
        """Return the whole job."""
        stages = [
            FollowCurve(self.required(curve), options=self.options, off=self.off, name=f"curve {number}")
            for number, curve in enumerate(self.curves, start=1)
        ]
        return Task(scene=self.scene, group=self.group, start=self.start, stages=stages, name=self.name)

    def measured(self) -> tuple[str, ...]:
        """Plan the job, and return its row of the table."""
        begin = time.process_time()
        result = to.plan(self.task())
        cpu = time.process_time() - begin
        certificate = result.certificate
        joints = len(self.scene.robot.group(self.group).joints)
        length = sum(curve.length for curve in self.curves)
        far, slow = worst(certificate, "curve position"), worst(certificate, "steady speed")
        return (
            self.name,
            f"{joints}",
            f"{len(self.curves)}",
            f"{length:.2f}",
            f"{result.duration:.1f}",
            f"{1e3 * max(far):.4f}",
            f"{100 * min(slow) / self.speed:.1f} %",
            f"{cpu:.1f}",
        )


def worst(certificate: Certificate, name: str) -> list[float]:
    """Return the values of all checks of a name, which have to be proven."""
    checks = [check for check in certificate.checks if check.name.endswith(f"path: {name}")]
    assert checks and all(check.holds and check.evidence is Evidence.PROVEN for check in checks)
    return [check.value or 0.0 for check in checks]


def wall(length: float = 3.0) -> Process:
    """Return three rows of a length [m] on a wall, for a PR2: base and arm move together."""
    past = to.named_problem("past_column_pr2")
    robot = past.scene.robot
    scene = (
        to.Scene(robot)
        .add("wall", to.Box(0.1, length + 0.6, 1.8), to.placement((1.25, 0.0, 0.9)))
        .with_tool(
            "brush", on="r_gripper_tool_frame", placement=to.placement((0, 0, 0), rpy=(0, np.pi / 2, 0))
        )
    )
    corners = np.array([(1.1, y, z) for y in (-length / 2, length / 2) for z in (0.7, 1.1)])
    rows = raster(to.Mesh(corners, np.array([(0, 1, 2), (1, 3, 2)])), face=0, spacing=0.2, along=(0, 1, 0))
    start = dict(zip(robot.joint_names, past.start_positions.tolist(), strict=True))
    name = f"{len(rows)} rows of {length:g} m on a wall, PR2 with its base"
    return Process(name, scene, past.group, start, "brush", rows, speed=0.2)


def beside_rail(length: float = 3.0) -> Process:
    """Return rows of a length [m] below a Panda on a rail."""
    folder = share_folder() / PANDA
    rail = to.bases.rail((0, 1, 0), -2.0, 2.0, velocity=0.5, acceleration=1.0, groups=("arm",))
    robot = to.load(
        folder / "urdf/panda.urdf", srdf=folder / "srdf/panda.srdf", package_dirs=(share_folder(),), base=rail
    )
    scene = to.Scene(robot).with_tool("tip", on="panda_hand", placement=to.placement((0, 0, 0.1034)))
    corners = np.array([(x, y, 0.3) for x in (0.4, 0.6) for y in (-length / 2, length / 2)])
    rows = raster(to.Mesh(corners, np.array([(0, 2, 1), (1, 2, 3)])), face=0, spacing=0.1, along=(0, 1, 0))
    start = {"panda_joint2": -0.785, "panda_joint4": -2.356, "panda_joint6": 1.571, "panda_joint7": 0.785}
    name = f"{len(rows)} rows of {length:g} m beside a rail, Panda"
    return Process(name, scene, "arm", start, "tip", rows, speed=0.2)


def part() -> Process:
    """Return a raster on the mesh of a part, and three seams around it, for a Panda."""
    mesh = load_mesh(share_folder() / PART, (1.5, 1.5, 1.5))
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    at = to.placement((0.5, 0.0, -float(low[2])))
    scene = (
        to.Scene(to.load("panda"))
        .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("part", mesh, at)
        .with_tool("torch", on="panda_hand_tcp", placement=to.placement((0, 0, 0.05)))
    )
    normals = np.cross(
        mesh.triangles[:, 1] - mesh.triangles[:, 0], mesh.triangles[:, 2] - mesh.triangles[:, 0]
    )
    top = int(np.argmax((mesh.triangles[:, :, 2].min(axis=1) > high[2] - 1e-4) * normals[:, 2]))
    above = to.placement((0.5, 0.0, -float(low[2]) + 0.002))
    rows = raster(mesh, face=top, spacing=0.04, margin=0.01, at=above)
    name = f"raster of {len(rows)} rows and three seams on a mesh, Panda"
    curves = (*rows, *(seam(angle) for angle in (0.8, 2.8, 5.0)))
    return Process(name, scene, "panda_arm", "ready", "torch", curves, speed=0.02, cone=np.radians(15.0))


def seam(angle: float, turn: float = 0.6) -> Curve:
    """Return an arc around the part, with the torch tilted towards it."""
    centre = np.array((0.5, 0.0, 0.01))

    def pose(at: float) -> to.Placement:
        out = np.array((np.cos(at), np.sin(at), 0.0))
        inward = -np.sin(TILT) * out - np.cos(TILT) * np.array((0.0, 0.0, 1.0))
        side = np.array((-np.sin(at), np.cos(at), 0.0))
        return to.placement(
            centre + RIM * out, rotation=np.column_stack((side, np.cross(inward, side), inward))
        )

    return arc_about(pose(angle), pose(angle + turn), centre=centre)


def unreachable(process: Process) -> str:
    """Return a sentence about a seam that leaves the reach of the arm."""
    begin, end = (
        to.placement((0.5, 0.3, 0.1), rpy=(np.pi, 0, 0)),
        to.placement((1.3, 0.3, 0.1), rpy=(np.pi, 0, 0)),
    )
    curve = polyline((begin, end))
    found = follow(
        process.scene, process.required(curve), start="ready", group=process.group, options=process.options
    )
    assert found.verified
    assert found.stop is not None
    return (
        f"A seam that leaves the reach of the Panda: proven for {found.fraction * curve.length:.3f} of "
        f"{curve.length:.1f} m, then `{found.stop.status.name}`."
    )


def main() -> None:
    """Measure, print, and write the section of the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--page", type=Path, help="write the table into this page")
    given = parser.parse_args()
    on_part = part()
    heads = (
        "job",
        "joints",
        "curves",
        "length [m]",
        "cycle time [s]",
        "off the curve [mm]",
        "least speed",
        "CPU [s]",
    )
    rows = [process.measured() for process in (wall(), beside_rail(), on_part)]
    written = f"{table(heads, rows)}\n\n{unreachable(on_part)}"
    print(written)
    if given.page is not None:
        write_section(given.page, "process-paths", written)


if __name__ == "__main__":
    main()

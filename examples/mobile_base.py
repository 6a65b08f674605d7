"""A mobile base: an arm on a cart with two wheels drives around a column and reaches onto a table.

Base and arm are planned together. The wheels cannot move sideways: the certificate bounds the deviation of
wheels that turn as planned.
"""

import tempfile
from pathlib import Path

import trajopt as to

LINK = """<link name="{name}">
  <inertial><mass value="{mass}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="{centre}"/><geometry><box size="{size}"/></geometry></collision></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
  <origin xyz="{at}"/><axis xyz="{axis}"/>
  <limit lower="-2.5" upper="2.5" effort="100" velocity="1.5"/></joint>"""
URDF = "\n".join(
    (
        '<robot name="cart">',
        LINK.format(name="cart", mass=30, centre="0 0 0.2", size="0.5 0.4 0.3"),
        LINK.format(name="turret", mass=2, centre="0 0 0.1", size="0.1 0.1 0.18"),
        LINK.format(name="upper", mass=2, centre="0.25 0 0", size="0.44 0.06 0.06"),
        LINK.format(name="fore", mass=1, centre="0.2 0 0", size="0.34 0.05 0.05"),
        JOINT.format(name="turn", parent="cart", child="turret", at="0.1 0 0.36", axis="0 0 1"),
        JOINT.format(name="shoulder", parent="turret", child="upper", at="0 0 0.2", axis="0 1 0"),
        JOINT.format(name="elbow", parent="upper", child="fore", at="0.5 0 0", axis="0 1 0"),
        "</robot>",
    )
)


SRDF = """<robot name="cart">
  <group name="arm"><chain base_link="cart" tip_link="fore"/></group>
  <disable_collisions link1="cart" link2="turret" reason="Adjacent"/>
  <disable_collisions link1="turret" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="upper" link2="fore" reason="Adjacent"/>
</robot>"""


def load(folder):
    """Write the description into a folder, and load it on a base with two wheels."""
    urdf, srdf = folder / "cart.urdf", folder / "cart.srdf"
    urdf.write_text(URDF)
    srdf.write_text(SRDF)
    base = to.bases.planar_base(
        (-1.0, -3.0),  # least x and y [m]
        (5.0, 3.0),  # largest x and y [m]
        velocity=(0.8, 1.0),  # along x and y [m/s], and of yaw [rad/s]
        acceleration=(0.8, 1.5),
        groups=("arm",),
        drive=to.bases.Drive.DIFFERENTIAL,
    )
    return to.load(urdf, srdf=srdf, base=base)


def main():
    """Drive around the column, up to the table."""
    with tempfile.TemporaryDirectory() as folder:
        robot = load(Path(folder))
    scene = (
        to.Scene(robot)
        .add("column", to.Cylinder(radius=0.25, length=2.0), to.placement((1.5, 0.0, 1.0)))
        .add("table", to.Box(0.6, 1.2, 0.7), to.placement((3.4, 0.3, 0.35)))
    )
    goal = to.frame_placement(
        "fore", to.placement((3.2, 0.3, 0.9)), position_tolerance=5e-3, rotation_tolerance=3.14
    )
    problem = to.Problem(scene=scene, group="arm", start={"shoulder": -1.0, "elbow": 2.0}, goal=goal)
    plan = to.plan(problem).require()
    print(plan.trajectory.joint_names)
    print(plan.certificate)


if __name__ == "__main__":
    main()

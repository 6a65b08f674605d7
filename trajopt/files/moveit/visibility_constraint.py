"""Visibility constraint messages: a sensor looks at a target."""

import numpy as np

from trajopt.files.moveit.frames import Reading, read_frame
from trajopt.files.moveit.pose import read_placement
from trajopt.problem.requirements import Requirement, axis_alignment, gaze
from trajopt.scene.scene import Scene
from trajopt.values.documents.document import Node

VISIBILITY_FIELDS = (
    *("target_radius", "target_pose", "cone_sides", "sensor_pose"),
    *("max_view_angle", "max_range_angle", "sensor_view_direction", "weight"),
)
VIEW_AXES = (2, 1, 0)
"""Column of the sensor's axis by `sensor_view_direction`: z, y, x."""


def read_visibility(node: Node, scene: Scene, reading: Reading) -> tuple[Requirement, ...]:
    """Return the requirements of a visibility constraint.

    The range angle becomes a gaze: the line to the target lies within a cone about the sensor's axis. The
    view angle becomes an alignment of the sensor's axis with the target's -z. Obstacles in the cone between
    them are not checked, which is noted.

    Args:
        node: The message.
        scene: The scene.
        reading: Meaning of names; its notes receive a sentence on the unchecked obstacles.

    Raises:
        FileFormatError: If the message is malformed, or has neither angle.
        FrameNotFound: If it names an unknown frame.

    Source: MoveIt, `kinematic_constraints::VisibilityConstraint::decide`.
    """
    node.only(VISIBILITY_FIELDS)
    sensor, target = (node[key].only(("header", "pose")) for key in ("sensor_pose", "target_pose"))
    camera, reference = (read_frame(each["header"], scene, reading) for each in (sensor, target))
    here, there = (read_placement(each["pose"], reading.notes) for each in (sensor, target))
    direction = node["sensor_view_direction"].number(0.0)
    if direction not in range(len(VIEW_AXES)):
        raise node["sensor_view_direction"].error("must be 0 (z), 1 (y) or 2 (x)")
    axis = here.rotation[:, VIEW_AXES[int(direction)]]
    found: list[Requirement] = []
    range_angle, view_angle = _angle(node["max_range_angle"]), _angle(node["max_view_angle"])
    if range_angle > 0.0:
        found.append(
            gaze(
                camera,
                there.translation,
                angle=range_angle,
                axis=axis,
                origin=here.translation,
                reference=reference,
            )
        )
    if view_angle > 0.0:
        facing = -there.rotation[:, 2]
        found.append(
            axis_alignment(camera, axis=axis, direction=facing, tolerance=view_angle, reference=reference)
        )
    if not found:
        raise node.error("has neither max_range_angle nor max_view_angle; the cone alone is not supported")
    reading.notes.append(f"{node.place}: what stands between sensor and target is not looked at")
    return tuple(found)


def _angle(node: Node) -> float:
    """Return an angle in [0, pi/2]; as in MoveIt, the sensor must not face away."""
    angle = node.number(0.0)
    if angle < 0.0:
        raise node.error(f"is negative: {angle:g}")
    return min(angle, np.pi / 2.0)

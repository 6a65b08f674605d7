"""Planning scenes written to files, as `read_scene` reads them."""

from pathlib import Path
from typing import cast

from trajopt.files.messages.documents import document_of
from trajopt.files.messages.moveit_msgs import PlanningSceneComponents as Parts
from trajopt.files.moveit.joint_trajectory import write_message
from trajopt.files.moveit.state_message import scene_message
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats, floats, one_of
from trajopt.values.errors.arguments import checked

WRITTEN = (
    Parts.ROBOT_STATE
    + Parts.ROBOT_STATE_ATTACHED_OBJECTS
    + Parts.WORLD_OBJECT_NAMES
    + Parts.WORLD_OBJECT_GEOMETRY
    + Parts.TRANSFORMS
    + Parts.ALLOWED_COLLISION_MATRIX
    + Parts.LINK_PADDING_AND_SCALING
)


@checked
def write_scene(path: Path | str, scene: Scene, positions: Floats) -> None:
    """Write a scene as `moveit_msgs/PlanningScene`: JSON where the file's name ends so, else YAML.

    Margins, clearances by kind or by name, allowances for a time and motions have no place in that message:
    a bundle holds them (`result.save`).

    Args:
        path: The file.
        scene: The robot and what is around it.
        positions: Where all joints are, shape (number of joints,) [rad | m].

    Raises:
        FileFormatError: If the file cannot be written.
        ShapeError: If there is not one finite position for each joint.
    """
    at = floats("positions", positions, (len(one_of("scene", scene, Scene).robot.joint_names),))
    message = document_of(scene_message(scene, at, WRITTEN), "scene")
    write_message(path, cast("dict[str, object]", message.value))

"""Write planning scenes to files for `read_scene`."""

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
    """Write a scene as `moveit_msgs/PlanningScene`: JSON if the file name ends in .json, else YAML.

    This message cannot represent margins, clearances by kind or by name, temporary allowed contacts and
    motions; a bundle can (`result.save`).

    Args:
        path: The file.
        scene: The robot and its surroundings.
        positions: Of all joints, shape (number of joints,) [rad | m].

    Raises:
        FileFormatError: If the file cannot be written.
        ShapeError: If there is not one finite position for each joint.
    """
    at = floats("positions", positions, (len(one_of("scene", scene, Scene).robot.joint_names),))
    message = document_of(scene_message(scene, at, WRITTEN), "scene")
    write_message(path, cast("dict[str, object]", message.value))

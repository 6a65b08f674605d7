"""Robot state, attached objects and scene as messages."""

from trajopt.files.messages.geometry_msgs import TransformStamped
from trajopt.files.messages.moveit_msgs import (
    CollisionObject,
    LinkPadding,
    LinkScale,
    PlanningScene,
    PlanningSceneComponents,
    PlanningSceneWorld,
    RobotState,
)
from trajopt.files.messages.sensor_msgs import JointState, MultiDOFJointState
from trajopt.files.messages.std_msgs import Header
from trajopt.files.moveit.planar_joints import planar_joints, planar_placement
from trajopt.files.moveit.pose import transform_of
from trajopt.files.moveit.scene_messages import attached_messages, matrix_message, world_messages
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.placement import WORLD


def state_message(scene: Scene, positions: Floats) -> RobotState:
    """Return positions of all joints, and the attached objects, as a message."""
    robot, at = scene.robot, positions.tolist()
    named = dict(zip(robot.joint_names, at, strict=True))
    several = MultiDOFJointState()
    if planar_joints(robot.base.joints):
        x, y, yaw = (named.pop(joint) for joint in robot.base.joints)
        transform = transform_of(planar_placement(x, y, yaw))
        several = MultiDOFJointState(Header(frame_id=robot.base.frame), [robot.base.name], [transform])
    return RobotState(
        joint_state=JointState(name=list(named), position=list(named.values())),
        multi_dof_joint_state=several,
        attached_collision_objects=list(attached_messages(scene).values()),
    )


def scene_message(scene: Scene, positions: Floats, components: int) -> PlanningScene:
    """Return the requested components of a scene as a message.

    Args:
        scene: The scene.
        positions: Of all joints, shape (number of joints,) [rad | m].
        components: A sum of constants of `PlanningSceneComponents`.
    """
    asked, message = PlanningSceneComponents, PlanningScene(robot_model_name=scene.robot.name)
    frame = scene.robot.links[0]
    if components & (asked.ROBOT_STATE | asked.ROBOT_STATE_ATTACHED_OBJECTS):
        message.robot_state = state_message(scene, positions)
        if not components & asked.ROBOT_STATE_ATTACHED_OBJECTS:
            message.robot_state.attached_collision_objects = []
    if components & (asked.WORLD_OBJECT_NAMES | asked.WORLD_OBJECT_GEOMETRY):
        objects = world_messages(scene, frame)
        if not components & asked.WORLD_OBJECT_GEOMETRY:
            objects = {name: CollisionObject(id=name) for name in objects}
        message.world = PlanningSceneWorld(list(objects.values()))
    if components & asked.TRANSFORMS:
        message.fixed_frame_transforms = _fixed_frames(scene, frame)
    if components & asked.ALLOWED_COLLISION_MATRIX:
        message.allowed_collision_matrix = matrix_message(scene)
    if components & asked.LINK_PADDING_AND_SCALING:
        message.link_padding = [LinkPadding(*item) for item in scene.clearances.links.items()]
        scales = {body.owner: body.scale for body in scene.robot.bodies if body.scale != 1.0}
        message.link_scale = [LinkScale(*item) for item in scales.items()]
    return message


def _fixed_frames(scene: Scene, frame: str) -> list[TransformStamped]:
    """Return the frames without a shape: fixed world frames and tool frames."""
    standing = [name for name, item in scene.objects.items() if not item.parts and item.frame == WORLD]
    placed = [(frame, name, scene.object(name).placement) for name in standing]
    placed += [(item.frame, name, item.placement) for name, item in scene.tools.items()]
    return [TransformStamped(Header(frame_id=on), name, transform_of(where)) for on, name, where in placed]

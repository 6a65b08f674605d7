"""The messages of ROS that trajopt reads and writes, as a table.

Each entry reads `Name: type field, field; type field; ...`. `[]` marks an array, capitals constants. Fields
without a stated default are zero, false or empty, as in ROS.

Source: the `.msg`, `.srv` and `.action` files of ROS 1 Noetic and ROS 2 Jazzy, with the fields of both.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache

INTEGERS = {
    f"{sign}int{bits}": (0, 2**bits - 1) if sign else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
}
INITIAL: Mapping[str, object] = {
    **dict.fromkeys(INTEGERS, 0),
    **dict.fromkeys(("float32", "float64"), 0.0),
    "bool": False,
    "string": "",
    "uint8[]": b"",
}
"""Initial value of each plain type; an array of uint8 is one value, which rosbridge writes in base64."""

TABLE = {
    "builtin_interfaces": """
Time: int32 secs, nsecs
Duration: int32 secs, nsecs
""",
    "actionlib_msgs": """
GoalID: Time stamp; string id
GoalStatus: int32 PENDING=0, ACTIVE=1, PREEMPTED=2, SUCCEEDED=3, ABORTED=4, REJECTED=5, PREEMPTING=6,
    RECALLING=7, RECALLED=8, LOST=9; GoalID goal_id; uint8 status; string text
GoalStatusArray: Header header; GoalStatus[] status_list
""",
    "control_msgs": """
JointTolerance: string name; float64 position, velocity, acceleration
JointComponentTolerance: string joint_name; int32 component; float64 position, velocity, acceleration
FollowJointTrajectoryGoal: JointTrajectory trajectory; MultiDOFJointTrajectory multi_dof_trajectory;
    JointTolerance[] path_tolerance; JointComponentTolerance[] component_path_tolerance;
    JointTolerance[] goal_tolerance; JointComponentTolerance[] component_goal_tolerance;
    Duration goal_time_tolerance
FollowJointTrajectoryResult: int32 SUCCESSFUL=0, INVALID_GOAL=-1, INVALID_JOINTS=-2,
    OLD_HEADER_TIMESTAMP=-3, PATH_TOLERANCE_VIOLATED=-4, GOAL_TOLERANCE_VIOLATED=-5; int32 error_code;
    string error_string
FollowJointTrajectoryActionResult: Header header; GoalStatus status; FollowJointTrajectoryResult result
FollowJointTrajectoryFeedback: Header header; string[] joint_names; JointTrajectoryPoint desired, actual,
    error
""",
    "geometry_msgs": """
Point: float64 x, y, z
Point32: float32 x, y, z
Polygon: Point32[] points
Vector3: float64 x, y, z
Vector3Stamped: Header header; Vector3 vector
Quaternion: float64 x, y, z, w
Pose: Point position; Quaternion orientation
PoseStamped: Header header; Pose pose
Transform: Vector3 translation; Quaternion rotation
TransformStamped: Header header; string child_frame_id; Transform transform
Twist: Vector3 linear, angular
Accel: Vector3 linear, angular
PointStamped: Header header; Point point
QuaternionStamped: Header header; Quaternion quaternion
PoseArray: Header header; Pose[] poses
TwistStamped: Header header; Twist twist
Wrench: Vector3 force, torque
WrenchStamped: Header header; Wrench wrench
""",
    "moveit_msgs": """
PlanningOptions: PlanningScene planning_scene_diff; bool plan_only, look_around; int32 look_around_attempts;
    float64 max_safe_execution_cost; bool replan; int32 replan_attempts; float64 replan_delay
MoveGroupGoal: MotionPlanRequest request; PlanningOptions planning_options
MoveGroupResult: MoveItErrorCodes error_code; RobotState trajectory_start;
    RobotTrajectory planned_trajectory, executed_trajectory; float64 planning_time
MoveGroupFeedback: string state
ExecuteTrajectoryGoal: RobotTrajectory trajectory; string[] controller_names
ExecuteTrajectoryResult: MoveItErrorCodes error_code
ExecuteTrajectoryFeedback: string state
# positions and tolerances: [rad | m]
JointConstraint: string joint_name; float64 position, tolerance_above, tolerance_below, weight
BoundingVolume: SolidPrimitive[] primitives; Pose[] primitive_poses; Mesh[] meshes; Pose[] mesh_poses
PositionConstraint: Header header; string link_name; Vector3 target_point_offset;
    BoundingVolume constraint_region; float64 weight
OrientationConstraint: int32 XYZ_EULER_ANGLES=0, ROTATION_VECTOR=1; Header header; Quaternion orientation;
    string link_name; float64 absolute_x_axis_tolerance, absolute_y_axis_tolerance,
    absolute_z_axis_tolerance; uint8 parameterization; float64 weight
VisibilityConstraint: int32 SENSOR_Z=0, SENSOR_Y=1, SENSOR_X=2; float64 target_radius;
    PoseStamped target_pose; int32 cone_sides; PoseStamped sensor_pose; float64 max_view_angle,
    max_range_angle; uint8 sensor_view_direction; float64 weight
Constraints: string name; JointConstraint[] joint_constraints; PositionConstraint[] position_constraints;
    OrientationConstraint[] orientation_constraints; VisibilityConstraint[] visibility_constraints
TrajectoryConstraints: Constraints[] constraints
# message: the reason in one sentence; source: the component that reports it
MoveItErrorCodes: int32 SUCCESS=1, UNDEFINED=0, FAILURE=99999, PLANNING_FAILED=-1, INVALID_MOTION_PLAN=-2,
    MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE=-3, CONTROL_FAILED=-4, UNABLE_TO_AQUIRE_SENSOR_DATA=-5,
    TIMED_OUT=-6, PREEMPTED=-7, START_STATE_IN_COLLISION=-10, START_STATE_VIOLATES_PATH_CONSTRAINTS=-11,
    GOAL_IN_COLLISION=-12, GOAL_VIOLATES_PATH_CONSTRAINTS=-13, GOAL_CONSTRAINTS_VIOLATED=-14,
    INVALID_GROUP_NAME=-15, INVALID_GOAL_CONSTRAINTS=-16, INVALID_ROBOT_STATE=-17, INVALID_LINK_NAME=-18,
    INVALID_OBJECT_NAME=-19, FRAME_TRANSFORM_FAILURE=-21, COLLISION_CHECKING_UNAVAILABLE=-22,
    ROBOT_STATE_STALE=-23, SENSOR_INFO_STALE=-24, COMMUNICATION_FAILURE=-25, START_STATE_INVALID=-26,
    GOAL_STATE_INVALID=-27, UNRECOGNIZED_GOAL_TYPE=-28, CRASH=-29, ABORT=-30, NO_IK_SOLUTION=-31; int32 val;
    string message, source
PositionIKRequest: string group_name; RobotState robot_state; Constraints constraints;
    bool avoid_collisions; string ik_link_name; PoseStamped pose_stamped; string[] ik_link_names;
    PoseStamped[] pose_stamped_vector; Duration timeout; int32 attempts
ContactInformation: int32 ROBOT_LINK=0, WORLD_OBJECT=1, ROBOT_ATTACHED=2; Header header; Point position;
    Vector3 normal; float64 depth; string contact_body_1; uint32 body_type_1; string contact_body_2;
    uint32 body_type_2
CostSource: float64 cost_density; Vector3 aabb_min, aabb_max
ConstraintEvalResult: bool result; float64 distance
RobotTrajectory: JointTrajectory joint_trajectory; MultiDOFJointTrajectory multi_dof_joint_trajectory
CartesianPoint: Pose pose; Twist velocity; Accel acceleration
CartesianTrajectoryPoint: CartesianPoint point; Duration time_from_start
CartesianTrajectory: Header header; string tracked_frame; CartesianTrajectoryPoint[] points
GenericTrajectory: Header header; JointTrajectory[] joint_trajectory;
    CartesianTrajectory[] cartesian_trajectory
DisplayTrajectory: string model_id; RobotTrajectory[] trajectory; RobotState trajectory_start
DisplayRobotState: RobotState state; ObjectColor[] highlight_links; bool hide
WorkspaceParameters: Header header; Vector3 min_corner, max_corner
MotionPlanRequest: WorkspaceParameters workspace_parameters; RobotState start_state;
    Constraints[] goal_constraints; Constraints path_constraints;
    TrajectoryConstraints trajectory_constraints; GenericTrajectory[] reference_trajectories;
    string pipeline_id, planner_id, group_name; int32 num_planning_attempts; float64 allowed_planning_time,
    max_velocity_scaling_factor, max_acceleration_scaling_factor; string cartesian_speed_limited_link;
    float64 max_cartesian_speed; string cartesian_speed_end_effector_link
MotionPlanResponse: RobotState trajectory_start; string group_name; RobotTrajectory trajectory;
    float64 planning_time; MoveItErrorCodes error_code
PlannerInterfaceDescription: string name, pipeline_id; string[] planner_ids
GripperTranslation: Vector3Stamped direction; float32 desired_distance, min_distance
Grasp: string id; JointTrajectory pre_grasp_posture, grasp_posture; PoseStamped grasp_pose;
    float64 grasp_quality; GripperTranslation pre_grasp_approach, post_grasp_retreat, post_place_retreat;
    float32 max_contact_force; string[] allowed_touch_objects
PlaceLocation: string id; JointTrajectory post_place_posture; PoseStamped place_pose; float64 quality;
    GripperTranslation pre_place_approach, post_place_retreat; string[] allowed_touch_objects
CollisionObject: int32 ADD=0, REMOVE=1, APPEND=2, MOVE=3; Header header; Pose pose; string id;
    ObjectType type; SolidPrimitive[] primitives; Pose[] primitive_poses; Mesh[] meshes; Pose[] mesh_poses;
    Plane[] planes; Pose[] plane_poses; string[] subframe_names; Pose[] subframe_poses; int8 operation
AttachedCollisionObject: string link_name; CollisionObject object; string[] touch_links;
    JointTrajectory detach_posture; float64 weight
RobotState: JointState joint_state; MultiDOFJointState multi_dof_joint_state;
    AttachedCollisionObject[] attached_collision_objects; bool is_diff
AllowedCollisionEntry: bool[] enabled
AllowedCollisionMatrix: string[] entry_names; AllowedCollisionEntry[] entry_values;
    string[] default_entry_names; bool[] default_entry_values
# padding: clearance of the link from objects of the world [m]; scale: of its collision shapes
LinkPadding: string link_name; float64 padding
LinkScale: string link_name; float64 scale=1.0
ObjectColor: string id; ColorRGBA color
PlanningSceneWorld: CollisionObject[] collision_objects; OctomapWithPose octomap
# components: sum of the constants
PlanningSceneComponents: int32 SCENE_SETTINGS=1, ROBOT_STATE=2, ROBOT_STATE_ATTACHED_OBJECTS=4,
    WORLD_OBJECT_NAMES=8, WORLD_OBJECT_GEOMETRY=16, OCTOMAP=32, TRANSFORMS=64, ALLOWED_COLLISION_MATRIX=128,
    LINK_PADDING_AND_SCALING=256, OBJECT_COLORS=512; uint32 components
PlanningScene: string name; RobotState robot_state; string robot_model_name;
    TransformStamped[] fixed_frame_transforms; AllowedCollisionMatrix allowed_collision_matrix;
    LinkPadding[] link_padding; LinkScale[] link_scale; ObjectColor[] object_colors;
    PlanningSceneWorld world; bool is_diff
GetPositionFKRequest: Header header; string[] fk_link_names; RobotState robot_state
GetPositionFKResponse: PoseStamped[] pose_stamped; string[] fk_link_names; MoveItErrorCodes error_code
GetPositionIKRequest: PositionIKRequest ik_request
GetPositionIKResponse: RobotState solution; MoveItErrorCodes error_code
GetMotionPlanRequest: MotionPlanRequest motion_plan_request
GetMotionPlanResponse: MotionPlanResponse motion_plan_response
GetCartesianPathRequest: Header header; RobotState start_state; string group_name, link_name;
    Pose[] waypoints; float64 max_step, jump_threshold, prismatic_jump_threshold, revolute_jump_threshold;
    bool avoid_collisions; Constraints path_constraints; float64 max_velocity_scaling_factor,
    max_acceleration_scaling_factor; string cartesian_speed_limited_link, cartesian_speed_end_effector_link;
    float64 max_cartesian_speed
GetCartesianPathResponse: RobotState start_state; RobotTrajectory solution; float64 fraction;
    MoveItErrorCodes error_code
GetStateValidityRequest: RobotState robot_state; string group_name; Constraints constraints
GetStateValidityResponse: bool valid; ContactInformation[] contacts; CostSource[] cost_sources;
    ConstraintEvalResult[] constraint_result
GetPlanningSceneRequest: PlanningSceneComponents components
GetPlanningSceneResponse: PlanningScene scene
ApplyPlanningSceneRequest: PlanningScene scene
ApplyPlanningSceneResponse: bool success
QueryPlannerInterfacesRequest:
QueryPlannerInterfacesResponse: PlannerInterfaceDescription[] planner_interfaces
""",
    "object_recognition_msgs": """
ObjectType: string key, db
""",
    "octomap_msgs": """
Octomap: Header header; bool binary; string id; float64 resolution; int8[] data
OctomapWithPose: Header header; Pose origin; Octomap octomap
""",
    "sensor_msgs": """
JointState: Header header; string[] name; float64[] position, velocity, effort
MultiDOFJointState: Header header; string[] joint_names; Transform[] transforms; Twist[] twist;
    Wrench[] wrench
PointField: int32 INT8=1, UINT8=2, INT16=3, UINT16=4, INT32=5, UINT32=6, FLOAT32=7, FLOAT64=8; string name;
    uint32 offset; uint8 datatype; uint32 count
PointCloud2: Header header; uint32 height, width; PointField[] fields; bool is_bigendian; uint32 point_step,
    row_step; uint8[] data; bool is_dense
""",
    "shape_msgs": """
# dimensions [m], in the order of the constants
SolidPrimitive: int32 BOX=1, SPHERE=2, CYLINDER=3, CONE=4, PRISM=5, BOX_X=0, BOX_Y=1, BOX_Z=2,
    SPHERE_RADIUS=0, CYLINDER_HEIGHT=0, CYLINDER_RADIUS=1, CONE_HEIGHT=0, CONE_RADIUS=1, PRISM_HEIGHT=0;
    uint8 type; float64[] dimensions; Polygon polygon
MeshTriangle: uint32[] vertex_indices
Mesh: MeshTriangle[] triangles; Point[] vertices
# the half-space a x + b y + c z + d <= 0
Plane: float64[] coef
""",
    "std_msgs": """
Header: uint32 seq; Time stamp; string frame_id
ColorRGBA: float32 r, g, b, a
String: string data
Bool: bool data
Int8: int8 data
UInt8: uint8 data
Int16: int16 data
UInt16: uint16 data
Int32: int32 data
UInt32: uint32 data
Int64: int64 data
UInt64: uint64 data
Float32: float32 data
Float64: float64 data
Empty:
MultiArrayDimension: string label; uint32 size, stride
MultiArrayLayout: MultiArrayDimension[] dim; uint32 data_offset
Float64MultiArray: MultiArrayLayout layout; float64[] data
Float32MultiArray: MultiArrayLayout layout; float32[] data
Int8MultiArray: MultiArrayLayout layout; int8[] data
""",
    "trajectory_msgs": """
JointTrajectoryPoint: float64[] positions, velocities, accelerations, effort; Duration time_from_start
JointTrajectory: Header header; string[] joint_names; JointTrajectoryPoint[] points
MultiDOFJointTrajectoryPoint: Transform[] transforms; Twist[] velocities, accelerations;
    Duration time_from_start
MultiDOFJointTrajectory: Header header; string[] joint_names; MultiDOFJointTrajectoryPoint[] points
""",
    "visualization_msgs": """
Marker: int32 CUBE=1, SPHERE=2, CYLINDER=3, MESH_RESOURCE=10; Header header; string ns; int32 id, type,
    action; Pose pose; Vector3 scale; ColorRGBA color; string mesh_resource
MarkerArray: Marker[] markers
""",
}


@dataclass(frozen=True)
class MessageField:
    """A field of a message.

    Attributes:
        kind: Its type: a plain type of ROS or the full name of a message, with `[]` at the end of arrays.
    """

    name: str
    kind: str
    default: float | None = None


@dataclass(frozen=True)
class MessageDefinition:
    """The definition of a message."""

    name: str
    fields: tuple[MessageField, ...]
    constants: Mapping[str, int]


@cache
def definitions() -> Mapping[str, MessageDefinition]:
    """Return the definitions by full name."""
    texts = dict(_entries())
    full = {name.partition("/")[2]: name for name in texts}
    return {name: _definition(name, text, full) for name, text in texts.items()}


def _entries() -> Iterator[tuple[str, str]]:
    for package, text in TABLE.items():
        for entry in re.findall(r"^\w.*(?:\n    .*)*", text, re.MULTILINE):
            name, _, declared = entry.partition(":")
            yield f"{package}/{name}", " ".join(declared.split())


def _definition(name: str, declared: str, full: Mapping[str, str]) -> MessageDefinition:
    members: list[MessageField] = []
    constants: dict[str, int] = {}
    for statement in filter(None, declared.split("; ")):
        kind, _, names = statement.partition(" ")
        element = kind.removesuffix("[]")
        whole = full.get(element, element) + kind[len(element) :]
        for member in names.split(", "):
            key, _, value = member.partition("=")
            if key.isupper():
                constants[key] = int(value)
            else:
                members.append(MessageField(key, whole, float(value) if value else None))
    return MessageDefinition(name, tuple(members), constants)

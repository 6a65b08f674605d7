"""Pick and place: a box is taken from one table and put on another."""

import sys

from trajopt.ros import commander as moveit_commander
from trajopt.ros.commander import geometry_msgs, moveit_msgs


def at(x: float, y: float, z: float) -> geometry_msgs.msg.PoseStamped:
    """Return a pose in the frame of the base."""
    pose = geometry_msgs.msg.PoseStamped()
    pose.header.frame_id = "panda_link0"
    pose.pose.orientation.w = 1.0
    pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = x, y, z
    return pose


def main() -> int:
    """Take the box by a grasp that is made from its shape, and put it down."""
    group = moveit_commander.MoveGroupCommander("panda_arm")
    scene = moveit_commander.PlanningSceneInterface()
    group.set_max_velocity_scaling_factor(0.5)
    group.set_max_acceleration_scaling_factor(0.5)
    scene.add_box("table1", at(0.5, -0.35, 0.1), size=(0.4, 0.4, 0.2))
    scene.add_box("table2", at(0.5, 0.35, 0.1), size=(0.4, 0.4, 0.2))
    scene.add_box("box", at(0.45, -0.3, 0.25), size=(0.04, 0.05, 0.1))

    success = moveit_msgs.msg.MoveItErrorCodes.SUCCESS
    for step in ("pick", "place"):
        code = group.pick("box") if step == "pick" else group.place("box", at(0.45, 0.3, 0.25))
        carried = group.get_last_pick_place()
        print(step, code, carried.explain())
        if code != success:
            return 1
        for segment in carried.segments:
            print(segment.stage.name, segment.result.certificate)
    box = scene.get_object_poses(["box"])["box"].position
    print(f"the box is at {box.x:.3f} {box.y:.3f} {box.z:.3f}")
    return 0 if abs(box.y - 0.3) < 1e-3 else 1


if __name__ == "__main__":
    with moveit_commander.World("panda"):
        sys.exit(main())

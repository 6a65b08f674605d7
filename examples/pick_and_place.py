"""Pick and place: grasps and places are searched together, and each stage of the motion is proven."""

import trajopt as to
from trajopt.tasks.grasping import Place, grasps_of, gripper_of, pick_and_place


def main():
    """Carry a cup from one side of the table to the other."""
    panda = to.load("panda")
    scene = (
        to.Scene(panda)
        .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
        .add("cup", to.Cylinder(radius=0.03, length=0.12), to.placement((0.5, -0.2, 0.06)), mass=0.2)
    )
    grasps = grasps_of(scene, "cup", gripper_of(panda))
    places = Place(placement=to.placement((0.5, 0.25, 0.06)))
    carried = pick_and_place(scene, "cup", group="panda_arm", start="ready", grasps=grasps, places=places)
    print(carried.explain())
    for segment in carried.segments:
        print(f"{segment.stage.value}: {segment.trajectory.duration:.2f} s")
    print("the cup is at", carried.final_scene.object("cup").placement)


if __name__ == "__main__":
    main()

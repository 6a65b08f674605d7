"""A module beside a script, which the script imports."""

import rospy


def hand_over(group, scene):
    rospy.logwarn("handing over")
    scene.remove_attached_object(group.get_end_effector_link(), name="box")

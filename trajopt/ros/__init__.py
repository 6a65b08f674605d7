"""Faces for users of ROS: rosbridge and MoveIt's commander."""

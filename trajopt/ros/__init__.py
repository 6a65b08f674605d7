"""Faces for users of ROS: rosbridge, MoveIt's commander, and drivers of robots."""

"""Interfaces to ROS: rosbridge, MoveIt's commander, and robot drivers."""

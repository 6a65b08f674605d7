"""Readers of robot descriptions: URDF, SRDF, xacro, MJCF and Pinocchio models."""

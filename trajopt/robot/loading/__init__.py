"""Reading of a robot's description: URDF, SRDF, mimic joints, groups."""

"""Robots: kinematics, limits, groups, collision bodies and bases, and the loading of their descriptions."""

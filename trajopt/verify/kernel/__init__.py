"""Kinematics, distances, polynomials and bounds of the judge."""

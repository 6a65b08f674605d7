"""Shapes: boxes to meshes and clouds, and the surface that each one has."""

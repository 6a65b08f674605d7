"""Shapes, from boxes to meshes and clouds, and their surfaces."""

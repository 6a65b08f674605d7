"""Scenes: a robot among objects, dynamic obstacles, and the pairs of bodies that must keep apart."""

"""Scenes: a robot among objects, what moves, and which pairs of bodies must keep apart."""

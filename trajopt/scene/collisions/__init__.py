"""Collision: bodies, which pairs must keep apart, and by how much."""

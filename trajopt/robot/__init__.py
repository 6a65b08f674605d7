"""What exists: robots, scenes, shapes, limits and requirements, all immutable."""

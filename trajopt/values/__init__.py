"""Basic values: arrays, placements, shapes, curves, trajectories, errors and documents."""

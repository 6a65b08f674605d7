"""Values that everything is made of: arrays, placements, shapes, curves, errors and files."""

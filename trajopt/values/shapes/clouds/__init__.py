"""Clouds: what a camera, a scanner or a map tells of the surroundings, as shapes."""

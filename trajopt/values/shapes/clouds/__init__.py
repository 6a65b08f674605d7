"""Clouds: measurements of a camera, scanner or map as shapes."""

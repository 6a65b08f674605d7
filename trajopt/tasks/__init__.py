"""Tasks: follow a curve with a tool, pick and place objects."""

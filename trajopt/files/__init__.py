"""Files: bundles, MoveIt's YAML and messages, and exported motions."""

"""Files: text, YAML and JSON read with every value checked."""

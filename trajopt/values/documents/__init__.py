"""Text, YAML and JSON documents, read with every value checked."""

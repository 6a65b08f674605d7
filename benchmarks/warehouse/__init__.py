"""The warehouse: kills during writes, and the cost of keeping and finding."""

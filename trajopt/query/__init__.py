"""Numbers of given configurations: placements, signed distances, dynamics."""

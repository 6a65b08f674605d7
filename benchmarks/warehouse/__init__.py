"""What a warehouse takes: kills in the middle of writing, and how long it takes to keep and to find."""

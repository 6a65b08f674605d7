"""Criteria for every motion, and the checks of each kind of requirement."""

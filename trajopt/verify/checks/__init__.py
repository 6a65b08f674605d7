"""The checks of the judge, one for each requirement."""

"""Tasks above single motions: the tool along a curve, an object to another place."""

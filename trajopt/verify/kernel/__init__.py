"""What every check of the judge rests on: kinematics, distances, polynomials and bounds of its own."""

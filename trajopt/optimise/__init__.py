"""From a problem to a path: terms, transcription, solvers and methods, and inverse kinematics."""

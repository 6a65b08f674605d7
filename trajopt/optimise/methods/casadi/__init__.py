"""Knots by CasADi: kinematics as expressions, contacts as callbacks, solved by one of its plugins."""

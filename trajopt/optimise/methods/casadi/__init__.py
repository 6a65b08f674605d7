"""Knots by CasADi: kinematics as expressions, contacts as callbacks, solved by a CasADi plugin."""

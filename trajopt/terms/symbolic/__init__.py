"""Kinematics as CasADi expressions of the group's positions."""

from trajopt.terms.symbolic.kinematics import SymbolicKinematics as SymbolicKinematics

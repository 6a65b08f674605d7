"""Kinematics as CasADi expressions of the group's positions."""

from trajopt.symbolic.kinematics import SymbolicKinematics as SymbolicKinematics

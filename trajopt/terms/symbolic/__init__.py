"""Kinematics and residuals as CasADi expressions of the group's positions."""

from trajopt.terms.symbolic.kinematics import Symbolic as Symbolic
from trajopt.terms.symbolic.kinematics import SymbolicKinematics as SymbolicKinematics
from trajopt.terms.symbolic.kinematics import length as length

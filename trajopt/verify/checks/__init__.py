"""Criteria for every motion, and the checks of each kind of requirement.

The check of a kind is in the module with the name of its module in `trajopt.problem.requirements`, imported
on first use.
"""

"""The criteria that every motion is judged by, and the checks of each kind of requirement.

The check of a kind is in the module named after its subject, as its data in `trajopt.problem.requirements`;
it is imported when the judge meets the kind.
"""

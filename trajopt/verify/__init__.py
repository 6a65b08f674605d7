"""Independent judge of trajectories, from robot, scene and trajectory alone.

It shares no code with the planner. Checks marked as proven hold at all times.
"""

from trajopt.verify.certificate import (
    Certificate,
    Check,
    CheckKind,
    Counts,
    Evidence,
    PairClearance,
    Unproven,
)
from trajopt.verify.checks.quantities import When, check_requirement
from trajopt.verify.checks.torques import Overload
from trajopt.verify.examination import Examination, Moment, OutOfLimit, PairDistance
from trajopt.verify.judge import Judge, examine, verify
from trajopt.verify.kernel.options import VerifyOptions
from trajopt.verify.specification import SampledCheck, Specification, Verdict

__all__ = [
    "Certificate",
    "Check",
    "CheckKind",
    "Counts",
    "Evidence",
    "Examination",
    "Judge",
    "Moment",
    "OutOfLimit",
    "Overload",
    "PairClearance",
    "PairDistance",
    "SampledCheck",
    "Specification",
    "Unproven",
    "Verdict",
    "VerifyOptions",
    "When",
    "check_requirement",
    "examine",
    "verify",
]

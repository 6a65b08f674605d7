"""SRDF of a robot without one, and checks of its URDF."""

from trajopt.lab.srdf.groups import ProposedGroup as ProposedGroup
from trajopt.lab.srdf.groups import propose_groups as propose_groups
from trajopt.lab.srdf.judged_pairs import Confidence as Confidence
from trajopt.lab.srdf.judged_pairs import PairEvidence as PairEvidence
from trajopt.lab.srdf.judged_pairs import PairVerdict as PairVerdict
from trajopt.lab.srdf.judged_pairs import judge_pairs as judge_pairs
from trajopt.lab.srdf.proposal import SrdfProposal as SrdfProposal
from trajopt.lab.srdf.proposal import propose_srdf as propose_srdf
from trajopt.lab.srdf.proposal import srdf_text as srdf_text
from trajopt.lab.srdf.urdf_checks import Finding as Finding
from trajopt.lab.srdf.urdf_checks import Severity as Severity
from trajopt.lab.srdf.urdf_checks import check_urdf as check_urdf

"""The SRDF of a robot that has none: pairs with their evidence, groups, states; checks of its URDF."""

from trajopt.srdf_assistant.evidence import Confidence as Confidence
from trajopt.srdf_assistant.evidence import PairEvidence as PairEvidence
from trajopt.srdf_assistant.evidence import Verdict as Verdict
from trajopt.srdf_assistant.groups import ProposedGroup as ProposedGroup
from trajopt.srdf_assistant.groups import propose_groups as propose_groups
from trajopt.srdf_assistant.judged_pairs import judge_pairs as judge_pairs
from trajopt.srdf_assistant.proposal import SrdfProposal as SrdfProposal
from trajopt.srdf_assistant.proposal import propose_srdf as propose_srdf
from trajopt.srdf_assistant.urdf_checks import Finding as Finding
from trajopt.srdf_assistant.urdf_checks import Severity as Severity
from trajopt.srdf_assistant.urdf_checks import check_urdf as check_urdf
from trajopt.srdf_assistant.writer import srdf_text as srdf_text

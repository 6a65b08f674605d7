"""Proof files, by which a small checker without trajopt proves a motion.

Format: docs/proofs.md.
"""

from trajopt.files.proof.proof import SUFFIX as SUFFIX
from trajopt.files.proof.proof import MotionProof as MotionProof
from trajopt.files.proof.proof import ProofSize as ProofSize
from trajopt.files.proof.proof import check_proof as check_proof
from trajopt.files.proof.proof import prove as prove
from trajopt.files.proof.proof import save_proof as save_proof
from trajopt.files.proof.standing import StandingMotion as StandingMotion

"""Every motion that a test of the judge certifies is decided as well, as a whole and by each criterion."""

from collections.abc import Iterator

import pytest

from trajopt.values.trajectory import Trajectory
from trajopt.verify import Certificate, Judge, Specification


class Deciding:
    """A certifying judge that asks another one for its decision.

    Attributes:
        verdicts: How many decisions were compared.
    """

    def __init__(self) -> None:
        self.verdicts = 0
        self._certify = Judge.certify

    def certify(self, judge: Judge, trajectory: Trajectory, specification: Specification) -> Certificate:
        certificate = self._certify(judge, trajectory, specification)
        fresh = type(judge)(judge.reduced, judge.options)
        assert fresh.decide(trajectory, specification).verified == certificate.verified, certificate.verdict
        for criterion in fresh._criteria(trajectory, specification).criteria:
            failed = [check.name for check in criterion.measure() if check.required and not check.holds]
            assert criterion.holds() == (not failed), f"{type(criterion).__name__}: {failed}"
        self.verdicts += 1
        return certificate


@pytest.fixture(scope="module", autouse=True)
def deciding() -> Iterator[Deciding]:
    """Compare both verdicts on every motion that is judged."""
    both = Deciding()

    def certify(judge: Judge, trajectory: Trajectory, specification: Specification) -> Certificate:
        return both.certify(judge, trajectory, specification)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Judge, "certify", certify)
        yield both

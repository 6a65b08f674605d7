"""The fast kernel of proofs: the checks of `trajopt/verify/checker`, in doubles with error bounds."""

class StatedProof:
    """A statement, as JSON is read, with the bytes of its witness."""

    def __init__(self, statement: object, witness: bytes) -> None: ...
    def fault(self) -> str:
        """Return the first part that is not shown; empty if the statement is proven."""

    def leaves(self) -> list[bool]:
        """Return which leaves hold."""

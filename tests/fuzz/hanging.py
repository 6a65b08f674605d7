"""A problem that hangs and one that ends its process, for the guard of the random problems."""

import os
import time


def hang_or_die(family: str, seed: int) -> dict[str, object]:
    """Hang at seed 1, die at seed 2, answer at others."""
    if seed == 1:
        time.sleep(600.0)
    if seed == 2:
        os._exit(3)
    return {"key": f"{family}-{seed}", "family": family, "seed": seed, "outcome": "verified", "detail": ""}

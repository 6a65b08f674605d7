"""The stages of planning and of what comes after it, as whoever waits is told them."""

from collections.abc import Mapping

DOING: Mapping[str, str] = {
    "examine": "checking the start",
    "seed": "searching goal configurations",
    "optimise": "optimising",
    "retime": "timing",
    "verify": "judging",
    "simulate": "simulating",
    "render": "rendering",
}
"""The name of each stage while it runs."""

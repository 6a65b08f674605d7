"""Loops that keep to the machine's clock; moments and spans of time are messages."""

import time

from trajopt.files.messages.builtin_interfaces import Duration


class Rate:
    """Keeps a loop to so many rounds in a second."""

    def __init__(self, hz: float, reset: bool = False) -> None:
        """Begin the first round now.

        Args:
            hz: Rounds in a second, > 0.
            reset: As in ROS, for clocks that jump back; this one does not.
        """
        self.sleep_dur = Duration(1.0 / hz)
        self._begun = time.monotonic()

    def remaining(self) -> Duration:
        """Return what is left of the round; nothing if it took too long."""
        left = self._begun + self.sleep_dur.to_sec() - time.monotonic()
        return Duration(max(left, 0.0))

    def sleep(self) -> None:
        """Sleep until the round ends, and begin the next."""
        left = self.remaining().to_sec()
        time.sleep(left)
        round_length = self.sleep_dur.to_sec()
        self._begun = self._begun + round_length if left > 0.0 else time.monotonic()

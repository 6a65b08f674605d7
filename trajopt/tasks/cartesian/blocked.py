"""The reason why a curve cannot be followed farther: a joint, limit, pair of bodies or jump."""

from dataclasses import dataclass

import numpy as np

from trajopt.optimise.transcription.knots import CLEARANCE_TOLERANCE
from trajopt.optimise.transcription.margins import TaperedMargins, tapered_margins
from trajopt.planning.status import Status
from trajopt.robot.joints import joint_unit
from trajopt.robot.limits import LimitKind
from trajopt.tasks.cartesian.on_curve import OnCurve
from trajopt.tasks.cartesian.result import StopReason
from trajopt.tasks.cartesian.tracking import Track, track
from trajopt.values.arrays import Floats
from trajopt.values.printed import in_joint_position, in_unit

LOOK_AHEAD = 0.02
"""Distance beyond the last point in which the reason is searched [m]."""
STEPS_AHEAD = 8
"""Steps of that search."""
SEARCHES = 96
"""Random configurations for the search of another branch."""
ZOOMS = 7
"""Bisections that locate a violation between two stations."""
CAUTIOUS = 0.1
"""Assumed tool speed for time windows of intended contact [m/s]."""


@dataclass(frozen=True, eq=False)
class Clear:
    """The part of a track with sufficient clearance.

    Attributes:
        until: Last clear length along the curve [m].
        stop: The violated pair beyond it; None if the whole track is clear.
    """

    until: float
    stop: StopReason | None


@dataclass(frozen=True, eq=False)
class _Blocked:
    """The first sample at which a pair is too near, and its distance."""

    sample: int
    pair: int
    distance: float
    margin: float


def clear_part(on_curve: OnCurve, found: Track) -> Clear:
    """Find the part of a track on which every pair keeps its margin.

    Near the start the margin is reduced to the start's clearance, as for all planned motions.
    """
    margin = _margins(on_curve, found)
    s, q = found.stations, found.positions
    blocked = _first_blocked(on_curve, q, np.arange(len(s), dtype=np.float64), margin)
    if blocked is None:
        return Clear(found.reached, None)
    after = blocked.sample
    if after == 0:
        return Clear(0.0, _collision(on_curve, 0.0, blocked))
    low, high = 0.0, 1.0
    for _ in range(ZOOMS):
        share = (low + high) / 2.0
        estimate = (1.0 - share) * q[after - 1] + share * q[after]
        there = on_curve(estimate[None], np.array((s[after - 1] + share * (s[after] - s[after - 1]),)))
        hit = _first_blocked(on_curve, there.positions, np.array((after - 1 + share,)), margin)
        low, high = (share, high) if hit is None else (low, share)
        blocked = hit or blocked
    until = float(s[after - 1] + low * (s[after] - s[after - 1]))
    return Clear(until, _collision(on_curve, until, blocked))


def _margins(on_curve: OnCurve, found: Track) -> TaperedMargins:
    """Return the margins along a track; at the end of the curve those of the end, if it is clear."""
    query = on_curve.query
    goal: Floats | None = None
    if found.reached >= on_curve.required.until:
        touched = query.close_pairs(found.positions[-1:], query.reduced.pairs.required)
        goal = found.positions[-1] if len(touched.distance) == 0 else None
    return tapered_margins(query, max(len(found.stations), 2), goal, found.reached / CAUTIOUS)


def start_margins(on_curve: OnCurve, starts: Floats) -> Floats:
    """Return the clearance of each pair on the curve: its margin, or that at the starts, (p,)."""
    margin = on_curve.reduced.pairs.margin - CLEARANCE_TOLERANCE
    contacts = on_curve.query.close_pairs(starts, margin)
    np.minimum.at(margin, contacts.pair, contacts.distance - CLEARANCE_TOLERANCE)
    required = on_curve.reduced.pairs.required
    return np.where(required > 0.0, np.maximum(margin, required), margin)


def _first_blocked(
    on_curve: OnCurve, positions: Floats, places: Floats, margin: TaperedMargins
) -> _Blocked | None:
    contacts = on_curve.query.close_pairs(positions, on_curve.reduced.pairs.margin)
    asked = margin(contacts.pair, places[contacts.sample])
    short = asked - contacts.distance
    required = on_curve.reduced.pairs.required[contacts.pair]
    undercut = (required > 0.0) & (contacts.distance < np.minimum(required, asked))
    bad = np.flatnonzero((short > CLEARANCE_TOLERANCE) | undercut)
    if len(bad) == 0:
        return None
    sample = int(contacts.sample[bad].min())
    here = bad[contacts.sample[bad] == sample]
    worst = int(here[short[here].argmax()])
    return _Blocked(sample, int(contacts.pair[worst]), float(contacts.distance[worst]), float(asked[worst]))


def _collision(on_curve: OnCurve, s: float, blocked: _Blocked) -> StopReason:
    first, second = on_curve.reduced.owners(blocked.pair)
    required = float(on_curve.reduced.pairs.required[blocked.pair])
    kept = f"{blocked.margin * 1000.0:.1f} mm are required"
    if blocked.margin > required + CLEARANCE_TOLERANCE:
        kept = f"{blocked.margin * 1000.0:.1f} mm are kept along a curve, "
        kept += (
            f"{required * 1000.0:.3g} mm required and a margin"
            if required
            else "as a margin: Scene.with_margin lowers it"
        )
    return stop_reason(
        on_curve,
        Status.COLLISION,
        s,
        f"{first} comes within {blocked.distance * 1000.0:.1f} mm of {second}; {kept}",
        pair=(first, second),
        amount=blocked.margin - blocked.distance,
    )


def untracked(on_curve: OnCurve, found: Track, rng: np.random.Generator) -> StopReason | None:
    """Return the reason why a track ends before the curve; None if it does not.

    Args:
        on_curve: The curve and the arm.
        found: The track.
        rng: Draws configurations for the search of other branches.
    """
    s, until = found.reached, on_curve.required.until
    if s >= until:
        return None
    ahead = np.linspace(s, min(s + LOOK_AHEAD, until), STEPS_AHEAD + 1)
    q = found.positions[-1]
    (beyond,) = track(on_curve.without_limits(), ahead, q[None], np.full((1, len(q)), np.nan))
    limits = on_curve.reduced.limits
    excess = np.maximum(beyond.positions - limits.upper, limits.lower - beyond.positions)
    broken = np.flatnonzero((excess > 0.0).any(axis=1))
    if len(broken):
        joint = int(excess[broken[0]].argmax())
        name = limits.joint_names[joint]
        at = float(beyond.positions[broken[0], joint])
        over = at > limits.upper[joint]
        side, limit = (LimitKind.UPPER, limits.upper) if over else (LimitKind.LOWER, limits.lower)
        unit = joint_unit(on_curve.reduced.scene.robot.model, name)
        text = f"{name} is at its {side.value} limit of {in_joint_position(float(limit[joint]), unit)}"
        text += f"{limits.because(name, side)}, and the curve needs {in_joint_position(at, unit)} and more"
        return stop_reason(on_curve, Status.JOINT_LIMIT, s, text, joint=name, amount=float(limit[joint]))
    low = np.where(np.isfinite(limits.lower), limits.lower, -np.pi)
    high = np.where(np.isfinite(limits.upper), limits.upper, np.pi)
    drawn = np.vstack((q[None], rng.uniform(low, high, (SEARCHES, len(low)))))
    other = on_curve(drawn, np.full(len(drawn), ahead[1]))
    singular = float(on_curve.smallest_singular_value(q[None], np.array((s,)))[0])
    if other.held.any():
        jumps = np.abs(other.positions[other.held] - q)
        nearest = jumps[int(jumps.max(axis=1).argmin())]
        joint = int(nearest.argmax())
        name = limits.joint_names[joint]
        jump = in_unit(float(nearest[joint]), joint_unit(on_curve.reduced.scene.robot.model, name))
        text = (
            f"{name} would have to jump by {jump}; "
            f"the smallest singular value of the Jacobian is {singular:.2g}"
        )
        return stop_reason(on_curve, Status.BRANCH_JUMP, s, text, joint=name, amount=float(nearest[joint]))
    text = f"no configuration holds the curve there; the smallest singular value is {singular:.2g}"
    return stop_reason(on_curve, Status.OUT_OF_REACH, s, text)


def stop_reason(
    on_curve: OnCurve,
    status: Status,
    s: float,
    message: str,
    *,
    joint: str | None = None,
    pair: tuple[str, str] | None = None,
    amount: float = 0.0,
) -> StopReason:
    """Return the stop at a length along the curve, with its reason."""
    pose = on_curve.required.curve.pose_before(s)
    return StopReason(status=status, at=s, pose=pose, message=message, joint=joint, pair=pair, amount=amount)

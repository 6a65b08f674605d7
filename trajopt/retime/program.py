"""The program of a jerk-limited profile: minimise the duration within rows of limits.

The unknowns are control values z at the stations of a squared clock speed y, a quadratic B-spline as in
`trajopt.retime.profile`, but positive at the ends too. With p = dq/dclock and so on, at a grid point

    acceleration  q'' = p u + p' y,                   u = y' / 2,
    jerk          q''' = sqrt(y) (p y'' / 2 + 3/2 p' y' + p'' y).

The acceleration is linear in z. The jerk's limit reads |linear in z| <= jerk / sqrt(y), whose right-hand
side is convex: its tangent lies below, so that what holds with the tangent holds truly.

Source: the form of the rows is that of Debrouwere et al., Time-optimal path following for robots with
convex-concave constraints using sequential convex programming, IEEE T-RO 29(6), 2013.
"""

from dataclasses import dataclass

from trajopt.arrays import Floats


@dataclass(frozen=True, eq=False)
class Program:
    """Rows of limits, in blocks of three neighbouring control values, one block an interval of the grid.

    Attributes:
        weight: Of 1 / sqrt(z) in the duration, shape (k + 1,) [s].
        bound: What z must stay below, shape (k + 1,).
        rows: Factors of the values, shape (k - 1, m + r, 3): m of acceleration and torque, then r of jerk.
        above: What the first m values must stay below, positive, shape (k - 1, m).
        below: What their negatives must stay below, positive, shape (k - 1, m).
        jerk: Limits of the other values times sqrt(y), shape (k - 1, r).
        speed: Factors of y at the start and at the end of each interval, shape (k - 1, 2, 3).
    """

    weight: Floats
    bound: Floats
    rows: Floats
    above: Floats
    below: Floats
    jerk: Floats
    speed: Floats

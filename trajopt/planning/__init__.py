"""Planning: first guesses of many kinds, each optimised, timed and judged, within a budget."""

from trajopt.planning.attempts import Attempts as Attempts
from trajopt.planning.meter import Meter as Meter
from trajopt.planning.meter import Progress as Progress
from trajopt.planning.portfolio import Portfolio as Portfolio
from trajopt.planning.search import Search as Search

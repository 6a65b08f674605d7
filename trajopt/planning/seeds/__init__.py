"""Seeds of a path: one module for each kind of source."""

from trajopt.planning.seeds.lines import Bumps as Bumps
from trajopt.planning.seeds.lines import DetourLines as DetourLines
from trajopt.planning.seeds.lines import StraightLines as StraightLines
from trajopt.planning.seeds.lines import straight_line as straight_line
from trajopt.planning.seeds.sampled import SampledPaths as SampledPaths
from trajopt.planning.seeds.source import Blocked as Blocked
from trajopt.planning.seeds.source import Check as Check
from trajopt.planning.seeds.source import GivenPaths as GivenPaths
from trajopt.planning.seeds.source import GivenSeed as GivenSeed
from trajopt.planning.seeds.source import MakeSeed as MakeSeed
from trajopt.planning.seeds.source import NoSeed as NoSeed
from trajopt.planning.seeds.source import SeedContext as SeedContext
from trajopt.planning.seeds.source import SeedKind as SeedKind
from trajopt.planning.seeds.source import SeedLike as SeedLike
from trajopt.planning.seeds.source import SeedSource as SeedSource
from trajopt.planning.seeds.source import stated_seeds as stated_seeds
from trajopt.planning.seeds.source import with_knots as with_knots
from trajopt.planning.seeds.waypoints import WaypointLine as WaypointLine
from trajopt.planning.seeds.waypoints import choose_waypoints as choose_waypoints
from trajopt.planning.seeds.waypoints import least_steps as least_steps
from trajopt.planning.seeds.waypoints import line_through as line_through

"""Numbers of given configurations: placements, signed distances, dynamics."""

from trajopt.query.query import Contacts as Contacts
from trajopt.query.query import Counts as Counts
from trajopt.query.query import Kinematics as Kinematics
from trajopt.query.query import Query as Query
from trajopt.query.route import SearchSpace as SearchSpace
from trajopt.query.route import search_route as search_route

"""Numbers of given configurations: placements, signed distances, dynamics."""

from trajopt.query.covered import covered_query as covered_query
from trajopt.query.path_search import SearchSpace as SearchSpace
from trajopt.query.path_search import search_path as search_path
from trajopt.query.query import Contacts as Contacts
from trajopt.query.query import Counts as Counts
from trajopt.query.query import Kinematics as Kinematics
from trajopt.query.query import Query as Query

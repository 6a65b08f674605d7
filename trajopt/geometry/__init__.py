"""Numbers of given configurations: placements, signed distances, dynamics."""

from trajopt.geometry.covered import covered_query as covered_query
from trajopt.geometry.path_search import SearchSpace as SearchSpace
from trajopt.geometry.path_search import search_path as search_path
from trajopt.geometry.query import Contacts as Contacts
from trajopt.geometry.query import JointPlacements as JointPlacements
from trajopt.geometry.query import Query as Query
from trajopt.geometry.query import WorkCounts as WorkCounts

"""Numbers of given configurations: placements, signed distances, dynamics."""

from trajopt.geometry.covered import covered_query as covered_query
from trajopt.geometry.dynamic_obstacles import DynamicObstacles as DynamicObstacles
from trajopt.geometry.dynamic_obstacles import ObstacleContacts as ObstacleContacts
from trajopt.geometry.evaluation import Contacts as Contacts
from trajopt.geometry.evaluation import Evaluator as Evaluator
from trajopt.geometry.evaluation import JointPlacements as JointPlacements
from trajopt.geometry.evaluation import MakesEvaluator as MakesEvaluator
from trajopt.geometry.evaluation import WorkCounts as WorkCounts
from trajopt.geometry.evaluation import angular_jacobian as angular_jacobian
from trajopt.geometry.evaluation import point_jacobian as point_jacobian
from trajopt.geometry.query import Query as Query
from trajopt.geometry.query import SearchedPath as SearchedPath
from trajopt.geometry.query import SearchSpace as SearchSpace
from trajopt.geometry.query import evaluator as evaluator
from trajopt.geometry.query import search_path as search_path

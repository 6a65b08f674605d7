"""Numbers of given configurations: placements, signed distances, dynamics."""

from trajopt.query.choice import query_of as query_of
from trajopt.query.contacts import Contacts as Contacts
from trajopt.query.kinematics import Counts as Counts
from trajopt.query.kinematics import Kinematics as Kinematics
from trajopt.query.query import Query as Query

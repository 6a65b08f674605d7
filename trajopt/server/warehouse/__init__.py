"""The warehouse: robots, scenes, problems, plans, states and constraints in one file, by name."""

from trajopt.server.warehouse.kept import Constraints as Constraints
from trajopt.server.warehouse.kept import Entry as Entry
from trajopt.server.warehouse.kept import Kind as Kind
from trajopt.server.warehouse.kept import State as State
from trajopt.server.warehouse.warehouse import Warehouse as Warehouse

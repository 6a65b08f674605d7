"""The warehouse: robots, scenes, problems, plans, states and constraints in one file, kept by name."""

from trajopt.warehouse.kept import Constraints as Constraints
from trajopt.warehouse.kept import Entry as Entry
from trajopt.warehouse.kept import Kind as Kind
from trajopt.warehouse.kept import State as State
from trajopt.warehouse.warehouse import Warehouse as Warehouse

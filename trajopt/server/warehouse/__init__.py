"""The warehouse: robots, scenes, problems, plans, states and constraints in one file, by name."""

from trajopt.server.warehouse.kept import Constraints as Constraints
from trajopt.server.warehouse.kept import Entry as Entry
from trajopt.server.warehouse.kept import EntryKind as EntryKind
from trajopt.server.warehouse.kept import StoredState as StoredState
from trajopt.server.warehouse.warehouse import Warehouse as Warehouse

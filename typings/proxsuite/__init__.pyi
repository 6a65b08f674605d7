"""Types of what trajopt uses of proxsuite 0.8.0: the sparse backend of ProxQP."""

from . import proxqp as proxqp

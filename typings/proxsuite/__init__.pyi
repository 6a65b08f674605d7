"""Types of what trajopt uses of proxsuite 0.8.0: the backends of ProxQP."""

from . import proxqp as proxqp

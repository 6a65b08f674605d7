"""Numbers for Prometheus."""

from collections.abc import Callable, Iterator, Mapping

from prometheus_client import CollectorRegistry, Counter, Histogram, generate_latest
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.registry import Collector

from trajopt.server.job import Done
from trajopt.server.memory import memory_used
from trajopt.server.pool import WorkerPool
from trajopt.server.service import Service

SECONDS = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0)
"""Bounds of the histogram of durations, from kinematics to hard plans [s]."""


class Metrics:
    """Counts requests, and reads the state of a service on demand."""

    def __init__(self) -> None:
        """Have counted nothing yet."""
        self._registry = CollectorRegistry()
        labels = ("operation", "outcome")
        self._requests = Counter("trajopt_requests", "Requests", labels, registry=self._registry)
        self._seconds = Histogram(
            "trajopt_request_seconds", "Duration", labels[:1], registry=self._registry, buckets=SECONDS
        )
        self._cpu = Counter(
            "trajopt_request_cpu_seconds", "Processor time of workers", labels[:1], registry=self._registry
        )

    def of(self, service: Service) -> None:
        """Read a service."""
        self._registry.register(ServiceState(service))

    def count(self, done: Done) -> None:
        """Count a request that is over."""
        outcome = "answered" if done.why is None else done.why.name.lower()
        self._requests.labels(done.operation, outcome).inc()
        self._seconds.labels(done.operation).observe(done.seconds)
        self._cpu.labels(done.operation).inc(done.cpu)

    def text(self) -> bytes:
        """Return everything in Prometheus' format."""
        return generate_latest(self._registry)


NUMBERS: Mapping[str, tuple[str, Callable[[WorkerPool], int]]] = {
    "waiting": ("Requests that wait", lambda pool: pool.waiting),
    "busy": ("Workers at work", lambda pool: pool.busy),
    "workers": ("Workers that are up", lambda pool: len(pool.pids)),
    "restarts": ("Workers started in place of others", lambda pool: pool.restarts),
    "memory_bytes": ("Memory of workers", lambda pool: sum(memory_used(pid) for pid in pool.pids)),
}
"""Gauges of the workers of each lane."""


class ServiceState(Collector):
    """The present state of a service."""

    def __init__(self, service: Service) -> None:
        """Read this service."""
        self._service = service

    def collect(self) -> Iterator[GaugeMetricFamily]:
        lanes = {lane.name.lower(): pool for lane, pool in self._service.pools.items()}
        for name, (words, read) in NUMBERS.items():
            family = GaugeMetricFamily(f"trajopt_{name}", words, labels=["lane"])
            for lane, pool in lanes.items():
                family.add_metric([lane], float(read(pool)))
            yield family
        yield GaugeMetricFamily("trajopt_sessions", "Sessions", value=len(self._service.sessions))

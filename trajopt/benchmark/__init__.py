"""Benchmarks: the suite of installed problems, methods side by side, folders of scenes and requests."""

from trajopt.benchmark.compare import Allowance as Allowance
from trajopt.benchmark.compare import compare as compare
from trajopt.benchmark.compare import compared as compared
from trajopt.benchmark.instance import STANDARD as STANDARD
from trajopt.benchmark.instance import Definition as Definition
from trajopt.benchmark.instance import Instance as Instance
from trajopt.benchmark.instance import definitions as definitions
from trajopt.benchmark.instance import expected_status as expected_status
from trajopt.benchmark.instance import installed_definitions as installed_definitions
from trajopt.benchmark.instance import installed_instances as installed_instances
from trajopt.benchmark.outcome import Moment as Moment
from trajopt.benchmark.outcome import Outcome as Outcome
from trajopt.benchmark.running import run as run

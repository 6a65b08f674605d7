"""Benchmarks: the suite of installed problems, methods side by side, folders of scenes and requests."""

from trajopt.benchmark.compare import Allowance as Allowance
from trajopt.benchmark.compare import compare as compare
from trajopt.benchmark.compare import runs as runs
from trajopt.benchmark.definition import STANDARD as STANDARD
from trajopt.benchmark.definition import Definition as Definition
from trajopt.benchmark.definition import definitions as definitions
from trajopt.benchmark.definition import expected_status as expected_status
from trajopt.benchmark.definition import installed_definitions as installed_definitions
from trajopt.benchmark.entry import Entry as Entry
from trajopt.benchmark.entry import run as run
from trajopt.benchmark.run import Moment as Moment
from trajopt.benchmark.run import Run as Run
from trajopt.benchmark.suite_page import page as page
from trajopt.benchmark.suite_table import table as table

"""The suite of installed problems, methods side by side, folders of scenes and requests."""

from trajopt.lab.suite.instance import STANDARD as STANDARD
from trajopt.lab.suite.instance import Definition as Definition
from trajopt.lab.suite.instance import Instance as Instance
from trajopt.lab.suite.instance import definitions as definitions
from trajopt.lab.suite.instance import expected_status as expected_status
from trajopt.lab.suite.instance import installed_definitions as installed_definitions
from trajopt.lab.suite.instance import installed_instances as installed_instances
from trajopt.lab.suite.outcome import IterationRecord as IterationRecord
from trajopt.lab.suite.outcome import RunOutcome as RunOutcome
from trajopt.lab.suite.running import Allowance as Allowance
from trajopt.lab.suite.running import compare as compare
from trajopt.lab.suite.running import compared as compared
from trajopt.lab.suite.running import run as run

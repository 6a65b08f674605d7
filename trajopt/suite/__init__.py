"""The suite: every installed problem, planned, judged anew, and compared with what is expected of it."""

from trajopt.suite.definition import Definition as Definition
from trajopt.suite.definition import definitions as definitions
from trajopt.suite.definition import refused as refused
from trajopt.suite.entry import Entry as Entry
from trajopt.suite.entry import run as run
from trajopt.suite.page import page as page
from trajopt.suite.table import table as table

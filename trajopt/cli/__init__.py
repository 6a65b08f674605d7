"""The command line: `trajopt demo`, `plan`, `check`, `bench`, `suite`, `view`, `moveit` and others."""

from trajopt.cli.app import main as main

"""The command line: `trajopt demo`, `plan`, `check`, `bench`, `suite` and `view`."""

from trajopt.cli.app import main as main

"""The command line: `trajopt demo`, `plan`, `check`, `bench`, `suite`, `view`, `sample` and `reach`."""

from trajopt.cli.app import main as main

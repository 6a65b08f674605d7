"""The command line: `trajopt demo`, `plan`, `check`, `bench`, `suite`, `view`, `sample`, `reach`, `srdf`."""

from trajopt.cli.app import main as main

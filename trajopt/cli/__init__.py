"""The command line: `trajopt demo`, `plan`, `check`, `bench` and `view`."""

from trajopt.cli.app import main as main

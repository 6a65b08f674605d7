"""Imports pinocchio for the first time, without its own warning that it imports an old name of coal's."""

import warnings
from importlib import import_module

with warnings.catch_warnings():
    # pinocchio 3.8 imports `hppfcl`. Users can do nothing about it, and with `-W error` they could not begin.
    warnings.filterwarnings("ignore", "Please update your 'hppfcl' imports", DeprecationWarning)
    import_module("pinocchio")

"""The first import of pinocchio, without its deprecation warning about Coal's old name."""

import warnings
from importlib import import_module

with warnings.catch_warnings():
    # pinocchio 3.8 imports `hppfcl`. Users can do nothing about it, and with `-W error` they could not begin.
    warnings.filterwarnings("ignore", "Please update your 'hppfcl' imports", DeprecationWarning)
    import_module("pinocchio")

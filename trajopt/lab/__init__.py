"""Experiments: suites, campaigns, reach maps, perception and the SRDF assistant."""

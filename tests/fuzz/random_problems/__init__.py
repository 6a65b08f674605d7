"""Thousands of random problems, each judged by code that shares nothing with the planner and its judge."""

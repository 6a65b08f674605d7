"""Whole jobs: stages in order or in any order, planned as motions that rest only where a stage needs it."""

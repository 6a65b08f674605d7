"""Comparison: the same problems, first guesses, budget and judge for every method."""

from trajopt.comparison.compare import compare as compare
from trajopt.comparison.compare import runs as runs
from trajopt.comparison.planned import Allowance as Allowance
from trajopt.comparison.question import STANDARD as STANDARD
from trajopt.comparison.question import Question as Question
from trajopt.comparison.question import installed_questions as installed_questions
from trajopt.comparison.run import Moment as Moment
from trajopt.comparison.run import Run as Run

"""Explanations: the reason why there is no plan, remedies, and the prices of a plan's constraints."""

from trajopt.planning.status import Certainty as Certainty
from trajopt.why.change import ProblemChange as ProblemChange
from trajopt.why.change import Remedy as Remedy
from trajopt.why.explain import explain as explain
from trajopt.why.explanation import Explanation as Explanation
from trajopt.why.nearest import NearestFree as NearestFree
from trajopt.why.prices import Price as Price

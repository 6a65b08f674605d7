"""Why there is no plan and what would give one; of a plan, what its constraints cost."""

from trajopt.explanation.change import Change as Change
from trajopt.explanation.explain import explain as explain
from trajopt.explanation.explanation import Explanation as Explanation
from trajopt.explanation.nearest import NearestFree as NearestFree
from trajopt.explanation.prices import Price as Price
from trajopt.explanation.remedies import Remedy as Remedy
from trajopt.planning.status import Certainty as Certainty

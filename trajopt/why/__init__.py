"""Why there is no plan and what would give one; of a plan, what its constraints cost."""

from trajopt.planning.status import Certainty as Certainty
from trajopt.why.change import Change as Change
from trajopt.why.explain import explain as explain
from trajopt.why.explanation import Explanation as Explanation
from trajopt.why.nearest import NearestFree as NearestFree
from trajopt.why.prices import Price as Price
from trajopt.why.remedies import Remedy as Remedy

"""The live page: set a goal by hand, add objects, plan, scrub and execute.

State, planner and driver do not depend on the page, so they are tested without a browser.
"""

from trajopt.viewer.live.page import LiveView as LiveView
from trajopt.viewer.live.page import live_view as live_view

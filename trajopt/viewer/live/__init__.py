"""The live page: a goal set by hand, objects put up by hand, a motion planned, looked at and executed.

What is asked for (`Workbench`, `Goal`), what plans (`Planner`) and what drives the simulated robot (`Driver`)
know nothing of the page, so that they are tested without a browser.
"""

from trajopt.viewer.live.page import LiveView as LiveView
from trajopt.viewer.live.page import live_view as live_view

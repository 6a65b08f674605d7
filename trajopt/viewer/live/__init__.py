"""The live page: set a goal by hand, add objects, plan, scrub and execute."""

from trajopt.viewer.live.page import LiveView as LiveView
from trajopt.viewer.live.page import live_view as live_view

"""Views of motions in the browser (extra `view`), and as plots over time."""

from trajopt.viewer.explained import draw_explanation as draw_explanation
from trajopt.viewer.live import LiveView as LiveView
from trajopt.viewer.live import live_view as live_view
from trajopt.viewer.mirror import MirrorView as MirrorView
from trajopt.viewer.mirror import RunPublisher as RunPublisher
from trajopt.viewer.mirror import mirror_view as mirror_view
from trajopt.viewer.playback import Viewer as Viewer
from trajopt.viewer.playback import view as view
from trajopt.viewer.plots import plot_curve_map as plot_curve_map
from trajopt.viewer.plots import plot_motion as plot_motion
from trajopt.viewer.plots import plot_path_time as plot_path_time
from trajopt.viewer.plots import plot_reach as plot_reach
from trajopt.viewer.run_viewer import RunViewer as RunViewer
from trajopt.viewer.run_viewer import view_run as view_run
from trajopt.viewer.run_viewer import watch_run as watch_run
from trajopt.viewer.servo_page import ServoPage as ServoPage
from trajopt.viewer.servo_page import servo_page as servo_page

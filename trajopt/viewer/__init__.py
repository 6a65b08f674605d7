"""Views of motions: in the browser, and as plots over time.

`view` serves a page with the robot, its surroundings and a time slider (optional extra `view`), `watch_run`
one of a run while it goes on, `view_run` one of its recording, `live_view` one to set goals in by hand,
`mirror_view` one of a robot elsewhere, as a `Publisher` or a server tells of it;
`plot_motion` writes an image, `plot_path_time` one of what is in the way when, `plot_reach` one of a reach
map, `draw_explanation` one of what is in the way for good.
Nothing else in trajopt depends on them.
"""

from trajopt.viewer.explained import draw_explanation as draw_explanation
from trajopt.viewer.live import LiveView as LiveView
from trajopt.viewer.live import live_view as live_view
from trajopt.viewer.mirror import MirrorView as MirrorView
from trajopt.viewer.mirror import Publisher as Publisher
from trajopt.viewer.mirror import mirror_view as mirror_view
from trajopt.viewer.plots import plot_motion as plot_motion
from trajopt.viewer.plots import plot_path_time as plot_path_time
from trajopt.viewer.plots import plot_reach as plot_reach
from trajopt.viewer.run_viewer import RunViewer as RunViewer
from trajopt.viewer.run_viewer import view_run as view_run
from trajopt.viewer.run_viewer import watch_run as watch_run
from trajopt.viewer.servo_page import ServoPage as ServoPage
from trajopt.viewer.servo_page import servo_page as servo_page
from trajopt.viewer.viewer import Viewer as Viewer
from trajopt.viewer.viewer import view as view

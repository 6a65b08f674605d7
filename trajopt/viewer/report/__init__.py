"""Reports: a problem and its outcome as one page, for the screen and for paper.

`write_report(result, "report.html")` accepts a result, a plan, a problem or a bundle; `trajopt report` a
bundle.
"""

from trajopt.viewer.report.page import write_report as write_report

"""Reports: a problem and its outcome as one page."""

from trajopt.viewer.report.page import write_report as write_report

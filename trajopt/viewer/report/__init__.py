"""Reports: a problem and its outcome as one page, for the screen and for paper."""

from trajopt.viewer.report.page import write_report as write_report

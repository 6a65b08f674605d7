"""Reports: what was asked and what became of it, as one page to read, to turn and to print.

`write_report(result, "report.html")` writes one of a result, a plan, a problem or a bundle; `trajopt report`
does the same of a bundle.
"""

from trajopt.viewer.report.page import write_report as write_report

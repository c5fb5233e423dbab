"""The report: folders of results become one HTML page that needs nothing else."""

from mot_sim.report.page.page import MOST_BYTES, Report, write_report
from mot_sim.report.page.sources import Source, find_sources

__all__ = ["MOST_BYTES", "Report", "Source", "find_sources", "write_report"]

"""The report: folders of results become one HTML page that needs nothing else."""

from mot_sim.report.page.page import MAX_PAGE_BYTES, WrittenReport, write_report
from mot_sim.report.page.sources import ResultSource, find_sources

__all__ = ["MAX_PAGE_BYTES", "ResultSource", "WrittenReport", "find_sources", "write_report"]

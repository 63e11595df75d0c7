"""Text reports: what the command line prints and writes. No arithmetic beyond changing units."""

from stepid.report.section import Section, as_text
from stepid.report.text import identify_report
from stepid.report.text_paper import paper_report

__all__ = ["Section", "as_text", "identify_report", "paper_report"]

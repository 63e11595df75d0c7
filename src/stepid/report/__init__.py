"""Reports: they change units and compare, and compute nothing else. Exported are the texts of the command line."""

from stepid.report.pull import hand_method_table
from stepid.report.section import Section, as_text
from stepid.report.text_diagnosis import diagnosis_report
from stepid.report.text_identify import identify_report
from stepid.report.text_paper import paper_report

__all__ = ["Section", "as_text", "diagnosis_report", "hand_method_table", "identify_report", "paper_report"]

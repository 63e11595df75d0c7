"""Blind campaigns for a class: hide an effect in each group's records, seal the answers, check what comes back."""

from stepid.lab.answers import Answer as Answer
from stepid.lab.answers import Answers as Answers
from stepid.lab.assignment import Assignment as Assignment
from stepid.lab.assignment import confirm as confirm
from stepid.lab.assignment import open_answers as open_answers
from stepid.lab.blind import make as make
from stepid.lab.checks import Check as Check
from stepid.lab.checks import ParameterCheck as ParameterCheck
from stepid.lab.choice import Draw as Draw
from stepid.lab.marking import check as check
from stepid.lab.results import Results as Results
from stepid.lab.results import check_all as check_all
from stepid.lab.rig import Rig as Rig
from stepid.lab.rig import RunPlan as RunPlan
from stepid.lab.submission import Submission as Submission
from stepid.lab.submission import read_submission as read_submission
from stepid.lab.submission import read_submissions as read_submissions

__all__ = [
    "Answer",
    "Answers",
    "Assignment",
    "Check",
    "Draw",
    "ParameterCheck",
    "Results",
    "Rig",
    "RunPlan",
    "Submission",
    "check",
    "check_all",
    "confirm",
    "make",
    "open_answers",
    "read_submission",
    "read_submissions",
]

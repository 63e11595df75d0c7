"""Data that come with stepid: the paper's four runs, and a made-up lab campaign."""

from stepid.datasets.lab import LabTruth as LabTruth
from stepid.datasets.lab import lab_campaign as lab_campaign
from stepid.datasets.lab import lab_truth as lab_truth
from stepid.datasets.paper import PaperData as PaperData
from stepid.datasets.paper import burchett as burchett

__all__ = ["LabTruth", "PaperData", "burchett", "lab_campaign", "lab_truth"]

"""Data that come with stepid: the paper's four runs."""

from stepid.datasets.paper import PaperData as PaperData
from stepid.datasets.paper import burchett as burchett

__all__ = ["PaperData", "burchett"]

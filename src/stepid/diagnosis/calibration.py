"""How often answers were right that a rule gave: measured on made-up campaigns, clean and perturbed."""

from __future__ import annotations

PROBABILITY = {"complete": 0.95, "complete_but_open": 0.7, "leads": 0.7}
"""Rule of `stepid.diagnosis.verdict` to the share of its answers that held the truth."""

"""Units of the numbers in models, by the name of the field: for tables of models that have no words of their own."""

from __future__ import annotations

UNITS = {
    "added_mass": "kg",
    "added_masses": "kg",
    "base_mass": "kg",
    "mass": "kg",
    "masses": "kg",
    "in_milliseconds": "kg",  # masses that come out with times in ms
    "difference": "kg",
    "MassOffset.uncertainty": "kg",
    "stiffness": "N/m",
    "damping": "N·s/m",
    "damping_from_stiffness": "N·s/m",
    "pooled_damping": "N·s/m",
    "force_gain": "N/V",
    "static_gain": "m/V",
    "counts_per_meter": "1/m",
    "input_before": "V",
    "level": "V",
    "levels": "V",
    "drive_noise": "V",
    "sample_time": "s",
    "duration": "s",
    "start": "s",
    "end": "s",
    "before": "s",
    "hold": "s",
    "after": "s",
    "correlation_time": "s",
    "peak_time": "s",
    "settling_time": "s",
    "settling_time_measured": "s",
    "settling_time_simulated": "s",
    "first_order": "s",
    "second_order": "s²",
    "second_order_corrected": "s²",
    "damped_frequency": "rad/s",
    "natural_frequency": "rad/s",
    "peak": "m",
    "steady_state": "m",
    "rest": "m",
    "displacement": "m",
    "velocity": "m/s",
    "noise": "m",
    "noise_rms": "m",
    "rms": "m",
    "rms_before_peak": "m",
    "rms_after_peak": "m",
    "Gap.before": "m",
    "Gap.after": "m",
    "RunGap.before": "m",
    "RunGap.after": "m",
    "RunGap.phases": "m",
    "held_out_before": "m",
    "held_out_after": "m",
    "NoiseColor.white": "m",
    "NoiseColor.colored": "m",
    "fit_percent": "%",
}
"""A name that stands for one thing in one model and for another elsewhere has the model's name before it."""


def field_unit(model: str, field: str) -> str:
    """Return the unit of a field, empty where it is a pure number or no number."""
    return UNITS.get(f"{model}.{field}", UNITS.get(field, ""))

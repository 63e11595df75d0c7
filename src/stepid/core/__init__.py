"""What all rooms share: the frozen base model, experiments, estimates, the noise of a record, tables, units."""

"""The batched simulator: one step of many plants at once, and whole records solved at once."""

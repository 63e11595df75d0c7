"""Find where simulation and measurement disagree, name what is missing, add it, show the gap shrink."""

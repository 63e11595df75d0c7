"""What the page shows: the only place that imports Panel."""

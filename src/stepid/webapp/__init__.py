"""The page in a browser: what holds its state knows no Panel, what is shown lies in `views`."""

"""Joint fits of all records: least squares, many starts, score test, noise floor, covariance."""

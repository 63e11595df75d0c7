"""Plant models and the batched simulator: records as arrays, many plants one step at once, whole records at once."""

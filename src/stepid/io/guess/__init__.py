"""What files of recordings hold, found out from their bytes, names and numbers; pure functions, nothing is asked."""

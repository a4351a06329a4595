"""What tests of the data sets behind a table can have given: bounds and distributions."""

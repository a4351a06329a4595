"""Read data from other laboratories: any column names, any quantity, long or wide format."""

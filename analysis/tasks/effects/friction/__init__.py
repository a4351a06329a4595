"""Compare judgements with measured friction."""

"""Compare the paper's tables and figures with ours."""

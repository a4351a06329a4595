"""The study file: its model, its validation, and the plan of a run."""

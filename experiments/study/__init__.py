"""The study file: its model, validation and plan of a run."""

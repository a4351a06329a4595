"""A study and its analysis, frozen before there is data, and an analysis held against that."""

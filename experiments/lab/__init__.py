"""A laboratory: the folder that knows its study, and who has taken part and who comes next."""

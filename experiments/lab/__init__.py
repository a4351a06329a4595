"""The laboratory folder: its settings, its participants and who comes next."""

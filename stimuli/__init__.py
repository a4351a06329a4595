"""Stimuli: virtual surfaces, squeeze film, textures, masking noise."""

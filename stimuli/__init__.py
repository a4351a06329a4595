"""Define stimuli (virtual surfaces, textures and masking noise) and the squeeze-film models."""

"""What the finger feels: virtual surfaces, squeeze film, textures, masking noise."""

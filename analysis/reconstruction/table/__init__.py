"""Read and represent published tables."""

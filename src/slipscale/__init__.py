"""Laboratory software for ultrasonic tactile plates: run, pilot and analyse experiments.

The package is assembled from the top-level folders of the repository: `slipscale.analysis` is the
folder ``analysis``, and so on. In a wheel the folders are copied; for development, the editable
installation puts links to them next to this file (``tools/build_hook.py``).
"""

__version__ = "0.1.0"

"""Types of arrays."""

import numpy as np
from numpy.typing import NDArray

#: An array of floating-point numbers.
Array = NDArray[np.float64]

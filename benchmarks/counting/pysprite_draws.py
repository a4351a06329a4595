"""Draws by pysprite: reads a task as JSON from the command line, writes JSON."""

import json
import sys
import time

import numpy as np
from pysprite import Sprite

task = json.loads(sys.argv[1])
# pysprite draws from NumPy's global state.
np.random.seed(1)  # noqa: NPY002
sprite = Sprite(task["n"], task["mean"], task["sd"], 2, 2, task["low"], task["high"])
start = time.perf_counter()
_, found, _ = sprite.find_possible_distributions(task["draws"], init_method="random")
seconds = time.perf_counter() - start
print(json.dumps({"seconds": seconds, "found": [[float(v) for v in x] for x in found]}))

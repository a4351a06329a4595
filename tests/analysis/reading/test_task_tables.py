"""Tables of answered trials."""

import pandas as pd

from slipscale.analysis.reading.task_tables import by_task


def test_conditions_are_in_the_numerical_order_of_their_levels():
    rows = pd.DataFrame({"task": ["scale_hz-320", "scale_hz-20", "matching", "scale_hz-80.5"]})
    tasks = [task for task, _ in by_task(rows)]
    assert tasks == ["matching", "scale_hz-20", "scale_hz-80.5", "scale_hz-320"]

"""Run the command line with ``python -m slipscale``."""

import sys

from slipscale.commands import main

sys.exit(main())

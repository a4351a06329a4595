"""The table of pages, in the order of the navigation bar."""

from __future__ import annotations

from collections.abc import Callable

from slipscale.experiments.lab.console.pages.bench import bench
from slipscale.experiments.lab.console.pages.data import data, pilot
from slipscale.experiments.lab.console.pages.day import live, today
from slipscale.experiments.lab.console.pages.own_table import own_table
from slipscale.experiments.lab.console.pages.person import person
from slipscale.experiments.lab.console.pages.planning import planning
from slipscale.experiments.lab.console.pages.screens import screens
from slipscale.experiments.lab.console.pages.settings import settings
from slipscale.experiments.lab.console.pages.study import study
from slipscale.experiments.lab.console.pages.view import View

PAGES: dict[str, Callable[[View], dict[str, object]]] = {
    "today": today,
    "live": live,
    "study": study,
    "screens": screens,
    "planning": planning,
    "person": person,
    "data": data,
    "table": own_table,
    "pilot": pilot,
    "bench": bench,
    "settings": settings,
}
# Parent page of each subpage, which the navigation highlights.
WITHIN = {"screens": "study", "person": "today", "table": "data"}

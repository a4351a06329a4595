"""The table of all actions that a page can request.

Pages refer to participants, runs and pilots by label, never by path, and only existing labels are
accepted. Each action returns a sentence that is shown on the page.
"""

from __future__ import annotations

from slipscale.experiments.lab.console.actions import bench, data, folder, own_table, sessions
from slipscale.experiments.lab.console.actions.desk import Actions, Desk
from slipscale.experiments.lab.console.actions.forms import read_form
from slipscale.faults import UserError

TABLE: Actions = {
    **sessions.ACTIONS,
    **data.ACTIONS,
    **folder.ACTIONS,
    **bench.ACTIONS,
    **own_table.ACTIONS,
}


def do(desk: Desk, name: str, sent: bytes) -> str:
    """Carry out an action; return the sentence that the page shows.

    Raises
    ------
    UserError
        If the action does not exist or is not possible now, or if the data do not match its form.
    """
    if name not in TABLE:
        raise UserError("unknown action")
    form, action = TABLE[name]
    return action(desk, read_form(form, sent))

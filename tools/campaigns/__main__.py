"""Run a campaign: ``python -m tools.campaigns NAME ...``; --help lists the campaigns.

A campaign is a module in `CAMPAIGNS` with `add_arguments`, and with `run`, which returns the exit
status and the results for docs/validation/measured/campaigns.md, if any. The status is 1 if a
guarantee was violated.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "validation" / "measured" / "campaigns.md"
END = "<!-- end of figures -->\n"
CAMPAIGNS = {
    "torture": "torture.command",
    "windows": "windows",
    "soak": "soak",
    "output_states": "output_states.command",
    "wrong_boards": "wrong_boards.command",
    "reliability": "reliability",
    "unattended": "unattended",
    "disk": "torture.failing_writes",
}


def put(name: str, results: str) -> None:
    """Replace the results of a campaign on the page."""
    page = PAGE.read_text(encoding="utf-8")
    begin = f"<!-- figures: make {name} -->\n"
    before, mark, rest = page.partition(begin)
    _, end, after = rest.partition(END)
    if not (mark and end):
        raise LookupError(f"{PAGE}: no markers around the results of {name}")
    said = f"Latest results ({datetime.now(UTC).date()}, `make {name}`): {results}\n"
    PAGE.write_text(f"{before}{begin}{said}{END}{after}", encoding="utf-8")


def main(words: list[str] | None = None) -> int:
    """Run the named campaign with its arguments."""
    name, *arguments = words or sys.argv[1:] or ["--help"]
    if name not in CAMPAIGNS:
        parser = ArgumentParser(prog="python -m tools.campaigns", description="Run a campaign.")
        parser.add_argument("name", choices=CAMPAIGNS, help="NAME --help describes a campaign")
        parser.parse_args([name])
    campaign = import_module(f"tools.campaigns.{CAMPAIGNS[name]}")
    parser = ArgumentParser(
        prog=f"python -m tools.campaigns {name}",
        description=campaign.__doc__,
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("--write", action="store_true", help="update the documentation page")
    campaign.add_arguments(parser)
    args = parser.parse_args(arguments)
    status, results = campaign.run(args)
    if args.write and results:
        put(name, results)
    return int(status)


if __name__ == "__main__":
    sys.exit(main())

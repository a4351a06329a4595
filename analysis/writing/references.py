"""List the papers that a methods section cites, as text and as BibTeX."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """A cited paper.

    Parameters
    ----------
    cited : str
        Citation for sentences, such as "Friedman, 1937".
    authors : str
        Authors as in BibTeX, joined by " and ".
    title, journal, pages : str
        BibTeX fields, but with hyphens in page ranges.
    year : int
    volume : str
    """

    cited: str
    authors: str
    year: int
    title: str
    journal: str
    volume: str = ""
    pages: str = ""

    @property
    def listed(self) -> str:
        """Reference as an entry in a bibliography, with its title."""
        names = self.authors.replace(" and others", " et al.").replace(" and ", "; ")
        return f"{names} ({self.year}). {self.title}. {self._place}."

    @property
    def _place(self) -> str:
        place = (self.journal, self.volume, self.pages.replace("-", "–"))
        return ", ".join(part for part in place if part)

    @property
    def found_at(self) -> str:
        """Reference without its title, such as "Holm, 1979. Journal, 6, 65–70."."""
        return f"{self.cited}. {self._place}."

    def bibtex(self, key: str) -> str:
        """Return the BibTeX entry."""
        fields = {
            "author": self.authors,
            "title": f"{{{self.title}}}",
            "journal": self.journal,
            "year": str(self.year),
            "volume": self.volume,
            "pages": self.pages.replace("-", "--"),
        }
        lines = "".join(f"  {name} = {{{value}}},\n" for name, value in fields.items() if value)
        return f"@article{{{key},\n{lines}}}\n"


#: Key in references.bib -> paper.
REFERENCES: dict[str, Reference] = {
    key: Reference(**fields)
    for key, fields in tomllib.loads(
        Path(__file__).with_name("references.toml").read_text(encoding="utf-8")
    ).items()
}

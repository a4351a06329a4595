"""Recognise tables of known programs by their columns, and propose the meaning of the columns.

To support another program, add a line to `PRESETS`. The first preset with all marks applies.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class Preset:
    """Columns that a program writes.

    Parameters
    ----------
    name : str
        Name of the program or package.
    marks : tuple of str
        Columns of which each must exist, as regular expressions.
    columns : Mapping
        Column for each option, as a regular expression for its whole name, in lower case.
    fixed : Mapping
        Options with their values, for layouts that need no question.
    """

    name: str
    marks: tuple[str, ...]
    columns: Mapping[str, str] = field(default_factory=dict)
    fixed: Mapping[str, object] = field(default_factory=dict)


_PERSON = r".*(participant|subject|subj\b|observer|prolific|worker|person|judge|rater|^who$|^id$).*"
_ANSWER = r".*(correct|\.corr|^corr|^acc|\.acc|accuracy|answer|yes|felt|^hit).*"
_RESPONSE = r".*(estimate|rating|magnitude|\.response|^resp|judg|loudness|slider).*"
_YES = r"(k|yes|right|hits|n_?yes|n_?correct|n_?right|num_?correct|successes|resp_?yes)"
_NO = r"(no|wrong|misses|n_?no|n_?wrong|n_?incorrect|num_?wrong|failures|errors)"
_ALL = r"(n|n_?trials|n_?total|total|size)"
_PERCENT = r"(pc|percent|per_?cent|pct|percent_?(correct|yes|right))"
_CONSTANT = {"participant": _PERSON, "answer": _ANSWER, "response": _RESPONSE}
PRESETS = (
    Preset(
        name="psignifit, whose columns are levels, numbers of yes answers and of all answers",
        marks=(r"1", r"2", r"3"),
        fixed={"stimulus": "1", "yes_count": "2", "n": "3"},
    ),
    Preset(
        name="MLDS",
        marks=(r"resp", r"s1", r"s2", r"s3", r"s4"),
        fixed={"quadruple": "S1,S2,S3,S4", "answer": "resp"},
    ),
    Preset(
        name="MLDS",
        marks=(r"resp", r"s1", r"s2", r"s3"),
        fixed={"triad": "S1,S2,S3", "answer": "resp"},
    ),
    Preset(
        name="PsychoPy",
        marks=(r"psychopyversion",),
        columns={
            "participant": r"participant",
            "answer": r".*\.corr",
            "response": r".*\.(response|rating)",
        },
    ),
    Preset(
        name="OpenSesame",
        marks=(r"subject_nr", r"(opensesame_version|count_.*|experiment_file)"),
        columns={"participant": r"subject_nr", "answer": r"correct", "response": r"response"},
    ),
    Preset(
        name="Gorilla",
        marks=(r"participant private id",),
        columns={
            "participant": r"participant private id",
            "answer": r"correct",
            "response": r"response",
        },
    ),
    Preset(
        name="jsPsych",
        marks=(r"trial_type", r"trial_index", r"time_elapsed"),
        columns={
            "participant": _PERSON,
            "answer": r"correct",
            "response": r"(response|rating)(s?\..*)?",
        },
    ),
    Preset(
        name="lab.js",
        marks=(r"sender", r"sender_type", r"sender_id"),
        columns={"participant": _PERSON, "answer": r"correct", "response": r"response"},
    ),
    Preset(name="Qualtrics", marks=(r"responseid",), columns={"participant": r"responseid"}),
    Preset(
        name="E-Prime",
        marks=(r"experimentname", r"subject"),
        columns={"participant": r"subject", "answer": r".*\.acc", "response": r".*\.resp"},
    ),
    Preset(
        name="BIDS events",
        marks=(r"onset", r"duration"),
        columns={**_CONSTANT, "response": r".*(rating|response$|estimate).*"},
    ),
    Preset(
        name="counts of answers, as for quickpsy",
        marks=(_YES, _ALL),
        columns={"participant": _PERSON, "yes_count": _YES, "n": _ALL},
    ),
    Preset(
        name="counts of answers",
        marks=(_YES, _NO),
        columns={"participant": _PERSON, "yes_count": _YES, "no_count": _NO},
    ),
    Preset(
        name="percentages",
        marks=(_PERCENT, _ALL),
        columns={"participant": _PERSON, "percent": _PERCENT, "n": _ALL},
    ),
    Preset(name="", marks=(), columns=_CONSTANT),
)


def preset_of(names: Sequence[str]) -> Preset:
    """Return the first preset of which every mark is the name of a column."""
    return next(
        preset
        for preset in PRESETS
        if all(any(_fits(mark, name) for name in names) for mark in preset.marks)
    )


def columns_of(preset: Preset, names: Sequence[str]) -> dict[str, list[str]]:
    """Return the columns that each option of a preset could name."""
    return {
        option: [name for name in names if _fits(pattern, name)]
        for option, pattern in preset.columns.items()
    }


def _fits(pattern: str, name: str) -> bool:
    return re.fullmatch(pattern, name.lower()) is not None

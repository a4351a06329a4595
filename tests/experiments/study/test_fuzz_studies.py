"""Study files as people leave them, by the thousand: read and shown, or refused in a sentence.

A campaign of all such tests: ``make fuzz TEXTS=100000``.
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.running import study_commands
from experiments.study.file import study_text
from faults import UserError
from tools.fuzzing import bounded, campaign, changed_file
from tools.torture.pilots import EVERY_OPTION

STUDIES = [
    EVERY_OPTION.read_text(encoding="utf-8"),
    study_text("biet2007"),
    study_text("textures_demo"),
]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "study.toml"


@campaign(quick=150)
@given(st.sampled_from(STUDIES).flatmap(changed_file))
def test_a_study_is_shown_with_its_orders_or_refused_in_a_sentence(place, content):
    place.write_bytes(content)
    with bounded():
        try:
            shown = study_commands.show(str(place), "03", run="02")
        except UserError as error:
            assert str(error)  # noqa: PT017 - any sentence
            return
        assert "surfaces of participant 03" in shown
        assert str(place) in study_commands.validate(str(place))

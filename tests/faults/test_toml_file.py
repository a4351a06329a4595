"""A TOML file is a model, or a sentence about every fault."""

from __future__ import annotations

import subprocess
import sys
from contextlib import suppress
from typing import Annotated

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Field

from slipscale.faults import UserError
from slipscale.faults.toml_file import parse_toml, read_toml

Size = Annotated[int, Field(lt=2)]


class Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    mass_g: float = Field(default=1.0, gt=0)


class Whole(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    count: int = 0
    anything: object = None
    part: tuple[Part, ...] = ()


def test_a_file_that_fits_is_the_model(tmp_path):
    path = tmp_path / "whole.toml"
    path.write_text("count = 3\n[[part]]\nname = 'a'\n", encoding="utf-8-sig")
    assert read_toml(path, Whole) == Whole(count=3, part=(Part(name="a"),))


def test_every_fault_is_told_with_line_key_value_and_what_was_expected():
    text = "count = []\n[[part]]\nmass_g = -1\nmas = 1\n[[part]]\nname = 'b'\nmass_g = 0"
    with pytest.raises(UserError) as caught:
        parse_toml(text, "whole.toml", Whole)
    assert str(caught.value).splitlines() == [
        "whole.toml has 5 faults:",
        "  line 1, count: expected a whole number",
        "  line 2, name of item 1 of part: is missing",
        "  line 3, mass_g of item 1 of part: expected a number above 0, got -1",
        "  line 4, mas of item 1 of part: unknown key (did you mean 'mass_g'?)",
        "  line 7, mass_g of item 2 of part: expected a number above 0, got 0",
    ]


def test_a_bare_number_can_keep_its_decimals():
    found = parse_toml("anything = 12.50", "x.toml", Whole, parse_float=str)
    assert found.anything == "12.50"


@pytest.mark.parametrize(
    "text, said",
    [
        ("count = ", "x.toml: line 1 is not TOML: expected a value: words in"),
        (f"anything = {'[' * 5000}{']' * 5000}", "too many nested brackets"),
        (f"\nanything = {'[' * 50}{']' * 50}", "line 2, anything: .* at most 20 deep"),
        (f"\nanything.{'a.' * 5000}a = 1", "line 2, anything: .* at most 20 deep"),
        (f"\ncount = {'9' * 5000}", "line 2: a number can have at most 300 digits"),
        (f"\ncount = {'9' * 4000}", "line 2, count: expected a number of at most 300 digits"),
        (f"\ncount = 0x{'f' * 5000}", "line 2, count: expected a number of at most 300 digits"),
        (f"count = '{'9' * 5000}'", r"line 1, count: .*got '9{199} \.\.\.$"),
    ],
    ids=["syntax", "brackets", "deep", "dotted", "digits", "many digits", "hexadecimal", "string"],
)
def test_what_no_file_of_ours_says_is_refused_in_a_sentence(text, said):
    with pytest.raises(UserError, match=said) as caught:
        parse_toml(text, "x.toml", Whole)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("content", [None, b"\xff"], ids=["none", "not text"])
def test_a_file_that_cannot_be_read_is_named(tmp_path, content):
    path = tmp_path / "whole.toml"
    if content:
        path.write_bytes(content)
    with pytest.raises(UserError, match=r"whole\.toml: cannot be read \(.+\); expected a TOML"):
        read_toml(path, Whole)


PIECES = st.sampled_from(
    ["count", "part", "name", "mass_g", "x", "=", ".", ",", "[", "]", "[[part]]", "{", "}", "\n",
     "'", '"""', "#", "1", "1.5", "-", "9" * 400, "true", "2026-11-21", "07:32:00", "inf", "\\"]
)  # fmt: skip


@given(st.text() | st.lists(PIECES, max_size=30).map(" ".join) | st.lists(PIECES).map("".join))
@example("count = 1e400")
def test_any_text_is_a_model_or_a_users_mistake(text):
    for parse_float in (float, str):
        with suppress(UserError):
            assert isinstance(parse_toml(text, "any.toml", Whole, parse_float=parse_float), Whole)


def test_faults_load_no_pydantic():
    code = "import sys; import slipscale.faults.toml_file; print('pydantic' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


class Sizes(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    sizes: tuple[Size, ...] = ()


@pytest.mark.parametrize("text, hint", [("sizes = [0,5,1]", True), ("sises = [0,5,1]", False)])
def test_a_list_out_of_range_may_have_decimal_commas_but_not_an_unknown_key(text, hint):
    with pytest.raises(UserError) as refused:
        parse_toml(text, "a.toml", Sizes)
    assert ("write 0.5" in str(refused.value)) == hint

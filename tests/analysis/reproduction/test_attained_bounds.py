"""What holds in every data set that Table III allows, and the tables that attain each bound."""

from __future__ import annotations

import json

import pytest

from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.inference.conclusions import pairs
from slipscale.analysis.reconstruction.table.published_table import CONVENTIONS
from slipscale.analysis.reproduction import attained_bounds
from slipscale.analysis.reproduction.allowed_datasets import columns
from slipscale.analysis.reproduction.attained_bounds import known


@pytest.fixture
def sample():
    return {one.name: one for one in known("sample")}


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_every_bound_is_attained_by_a_table(convention):
    found = known(convention)
    assert [one.name.partition(".")[0] for one in found] == ["sign", "t"] * 6 + ["rm_f"]
    # The greatest F is not searched for.
    assert all(one.sharp for one in found if one.name != "rm_f")
    assert found[-1].at_low


@pytest.mark.parametrize(
    "pair, low, high",
    [
        ("0 um.0.5 um", 1.153, 4.163),
        ("0 um.1.2 um", 6.998, 29.6),
        ("0 um.2.3 um", 10.20, 85.5),
        ("0.5 um.1.2 um", 7.544, 59.2),
        ("0.5 um.2.3 um", 11.39, 69.5),
        ("1.2 um.2.3 um", 4.438, 43.0),
    ],
)
def test_t_has_the_ranges_that_another_search_found(sample, pair, low, high):
    found = sample[f"t.{pair}"]
    assert (found.low, found.high) == (pytest.approx(low, rel=5e-4), pytest.approx(high, rel=5e-4))


def test_what_was_derived_by_hand_and_prototype_holds(sample):
    everybody = sample["sign.0.5 um.1.2 um"]
    assert (everybody.low, everybody.high) == (12, 12)
    assert everybody.p_high == pytest.approx(2 / 4096)
    assert sample["sign.0 um.1.2 um"].low == 10
    assert sample["rm_f"].low == pytest.approx(88.36272, abs=5e-6)
    assert sample["rm_f"].p_high == pytest.approx(7.5e-16, rel=0.01)
    t, sign = sample["t.0 um.0.5 um"], sample["sign.0 um.0.5 um"]
    assert not t.decided
    assert (round(t.p_low, 4), round(t.p_high, 2)) == (0.0016, 0.27)
    assert (sign.low, sign.high) == (4, 11)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_the_search_finds_again_what_is_recorded(convention):
    """For the two shortest lists; the command that records searches all of them."""
    first = [Sampler(one.under(convention, "nearest")) for one in columns()[:2]]
    recorded = {one.name: one for one in known(convention)}
    for found in pairs(first):
        same = recorded[found.name]
        assert (found.low, found.high) == (pytest.approx(same.low), pytest.approx(same.high))


def test_a_recorded_table_that_is_not_table_3_is_refused(tmp_path, monkeypatch):
    entries = json.loads(attained_bounds.RECORDED.read_text())
    entries["sample"]["t.0 um.0.5 um"]["lowest"][0][0] += 1
    changed = tmp_path / "changed.json"
    changed.write_text(json.dumps(entries))
    monkeypatch.setattr(attained_bounds, "RECORDED", changed)
    with pytest.raises(ValueError, match=r"t\.0 um\.0\.5 um: column 0 um is not consistent"):
        known.__wrapped__("sample")

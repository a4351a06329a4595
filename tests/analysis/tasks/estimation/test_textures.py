"""Textures are described, and never pass for plain surfaces of their largest amplitude."""

import pandas as pd
import pytest

from slipscale.analysis.json_form import text
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preprocessing.normalisation import RULES
from slipscale.analysis.reporting.tables import tables
from slipscale.analysis.tasks.estimation import sentences


def with_textures(dataset, number, names=("coarse", "fine")):
    rows = dataset.default_estimates(number)
    for place, name in enumerate(names):
        # As large as a plain surface, and felt quite otherwise.
        others = {"texture": name, "surface": f"T{place + 1}", "scale_top": 100}
        rows.append(dataset.estimation_row(len(rows) + 1, 2.3, 10 * (place + 1) + number, **others))
    return rows


@pytest.fixture
def textured(dataset):
    rows = {f"{n:02d}": with_textures(dataset, n) for n in range(1, 5)}
    return dataset(participants=4, rows=rows)


def plain(folder):
    """Take the textures out of the files."""
    for path in folder.glob("sub-*/beh/*_beh.tsv"):
        lines = path.read_text().splitlines(keepends=True)
        path.write_text("".join(x for x in lines if "coarse" not in x and "fine" not in x))
    return folder


def test_no_model_of_amplitudes_depends_on_textures(textured):
    found, alone = analyse(textured), analyse(plain(textured))
    assert text(found.inference) == text(alone.inference)
    assert found.inference.mixed_model.trials == 4 * 6
    told = sentences.mixed_model(found.inference.mixed_model, 0.95, found.dataset.quantity)
    assert "random effects of participants on level and exponent" in told


@pytest.mark.usefixtures("figures_and_models_left_out")
@pytest.mark.parametrize("rule", [name for name in RULES if name != "standard_referenced"])
def test_nothing_that_is_said_of_amplitudes_depends_on_textures(textured, rule):
    found = analyse(textured, normalise=rule)
    alone = analyse(plain(textured), normalise=rule)
    pd.testing.assert_frame_equal(found.table3, alone.table3)
    pd.testing.assert_frame_equal(found.description, alone.description)
    pd.testing.assert_frame_equal(found.measures, alone.measures)
    assert text(found.inference) == text(alone.inference)
    assert len(found.textures) == 2
    assert not len(alone.textures)


def test_textures_are_on_the_scale_of_the_plain_surfaces_and_counted(textured, page):
    found = analyse(textured, normalise="scale_top")
    assert found.textures.to_dict(orient="list") == {
        "texture": ["coarse", "fine"],
        "n": [4, 4],
        "mean": [12.5, 22.5],
        "maximum_deviation": [pytest.approx(1.5)] * 2,
        "standard_deviation": [pytest.approx(1.2909944)] * 2,
    }
    assert found.dataset.counts["textures"] == 8
    assert found.dataset.counts["analysed"] == 4 * 8
    assert any(p.startswith("8 trials of textures (coarse, fine)") for p in found.problems)
    assert "textures" in tables(found)
    assert "Normalised estimates of textures" in page(found)


def test_the_surface_before_is_the_one_that_was_felt_before(dataset):
    def carried_over(place, texture):
        rows = {}
        for n in range(1, 7):
            # Two orders: of one order for all, effects of order are not computed.
            own = dataset.default_estimates(n)[:: 1 if n % 2 else -1]
            trial = dataset.estimation_row(0, 2.3, 50, texture=texture)
            rows[f"{n:02d}"] = [
                row | {"trial": number}
                for number, row in enumerate([*own[:place], trial, *own[place:]], start=1)
            ]
        found = analyse(dataset(rows=rows))
        first = found.estimates[found.estimates["participant_id"] == "sub-01"]
        effects = found.inference.order
        return first, effects.log_slope_per_level_before, effects.log_slope_per_trial

    table, *between = carried_over(3, "ridges")
    before = table["level"].shift()
    assert list(table["before_level"].isna()) == [True, False, False, True] + [False] * 4
    assert (table["before_level"] == before)[table["before_level"].notna()].all()
    assert list(table["position"]) == [1, 2, 3, 5, 6, 7, 8, 9]
    table, *last = carried_over(8, "ridges")
    assert list(table["before_level"].isna()) == [True] + [False] * 7
    assert between != last


def test_an_unanswered_trial_was_felt_before_the_next(dataset):
    rows = {}
    for n in range(1, 7):
        own = dataset.default_estimates(n)[:: 1 if n % 2 else -1]
        rows[f"{n:02d}"] = [row | {"trial": at} for at, row in enumerate(own, start=1)]
    rows["01"][2] |= {"estimate": "n/a"}
    found = analyse(dataset(rows=rows))
    table = found.estimates[found.estimates["participant_id"] == "sub-01"]
    shown = [row["amplitude_um_pp"] for row in rows["01"]]
    assert list(table["position"]) == [1, 2, 4, 5, 6, 7, 8]
    assert list(table["before_level"])[1:] == [shown[0], *shown[2:7]]


def test_a_study_without_textures_says_nothing_of_them(dataset):
    found = analyse(dataset(participants=3))
    assert "textures" not in tables(found)
    assert not any("texture" in problem for problem in found.problems)


def test_a_tidy_table_may_have_textures(table_by_hand):
    text = "participant_id,amplitude_um_pp,estimate,texture\na,1,5,\na,2,7,\na,2,3,ridges\n"
    data = load(table_by_hand(text))
    assert list(data.estimates["estimate"]) == [5, 7]
    assert list(data.textures["texture"]) == ["ridges"]

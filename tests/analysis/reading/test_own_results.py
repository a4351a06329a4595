"""Tables that an analysis wrote: the same result again, or refused with the data to use."""

import shutil

import pytest

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import OutsideTasks, analyse
from slipscale.analysis.reporting.files import write_analysis
from slipscale.analysis.writing.output_folder import default_folder
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.faults import UserError

STUDIES = ("biet2007", "constant_stimuli", "paired_comparison", "matching", "textures_demo")


@pytest.fixture(scope="module", params=STUDIES)
def pilot(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param) / "data"
    plans = pilot_plans(request.param, participants=3, seed=1, language="en")
    run_pilot(folder, plans, tell=lambda _: None)
    analysis = analyse(folder)
    return (
        folder,
        analysis,
        write_analysis(analysis, default_folder(analysis.dataset, folder)).parent,
    )


def test_every_table_in_its_folder_is_refused_with_the_data_set(pilot):
    folder, _, results = pilot
    before = sorted(path.name for path in results.parent.iterdir())
    tables = sorted(results.glob("*.csv"))
    assert tables
    for path in (*tables, results):
        with pytest.raises(UserError, match=r"expected the data .* slipscale analyse") as refused:
            load(path)
        assert str(refused.value).endswith(f"slipscale analyse {folder.resolve()}")
    assert sorted(path.name for path in results.parent.iterdir()) == before


def test_a_copy_of_every_table_has_the_same_result_or_is_refused(pilot, tmp_path):
    _, analysis, results = pilot
    read = []
    for path in results.glob("*.csv"):
        copy = shutil.copy(path, tmp_path)
        try:
            again = analyse(copy)
        except OutsideTasks:
            continue
        except UserError as refused:
            assert f"has the columns of {path.name}" in str(refused)  # noqa: PT017 - some are read
            continue
        read.append(path.name)
        assert again.rule == analysis.rule
        assert again.table3.equals(analysis.table3)
        assert again.inference.results["friedman"] == analysis.inference.results["friedman"]
    assert read == (["estimates.csv"] if len(analysis.estimates) else [])


def test_the_command_refuses_every_table_and_its_copy_as_python_does(pilot, tmp_path, capsys):
    _, _, results = pilot
    tables = sorted(results.glob("*.csv"))
    copies = [shutil.copy(path, tmp_path) for path in tables if path.name != "estimates.csv"]
    for table in (*tables, *copies):
        with pytest.raises(UserError) as refused:
            load(table)
        assert commands.main(["analyse", str(table)]) == 2
        assert str(refused.value) in capsys.readouterr().err


def test_a_table_s_results_are_refused_with_the_table_even_in_the_same_folder(table_by_hand):
    rows = [f"p{who},{a},{who + 10 * a}" for who in range(4) for a in (0.5, 1.2, 2.3)]
    source = table_by_hand("participant_id,amplitude_um_pp,estimate\n" + "\n".join(rows))
    found = analyse(source)
    for folder in (default_folder(found.dataset, source), source.parent):
        write_analysis(found, folder)
        with pytest.raises(UserError, match=rf"slipscale analyse {source.resolve()}$"):
            load(folder / "estimates.csv")
    assert len(load(source).estimates) == 12


def test_a_table_states_one_known_rule_and_analysis_toml_decides(table_by_hand):
    header = "participant_id,amplitude_um_pp,estimate,normalisation\n"
    path = table_by_hand(header + "a,0.5,3,top_stimulus\na,1.2,6,top_stimulus\n")
    assert load(path).choices.normalisation == "top_stimulus"
    (path.parent / "analysis.toml").write_text('[analysis]\nnormalisation = "none"\n')
    assert load(path).choices.normalisation == "none"
    for other in ("none", "largest"):
        mixed = table_by_hand(header + f"a,0.5,3,scale_top\na,1.2,6,{other}\n")
        with pytest.raises(UserError, match="expected the same rule in every row: one of none"):
            load(mixed)

"""Any parameter of a stimulus as the level of any protocol: what `vary` in a study file does."""

import re
from pathlib import Path

import pytest

from slipscale.analysis.load import load
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.participants.simulated_people.growth import people_for
from slipscale.experiments.participants.simulated_people.population import curves
from slipscale.experiments.running.begin_or_resume import plate_for
from slipscale.experiments.running.pilot import run_simulated
from slipscale.experiments.running.rehearsal import check_supported
from slipscale.experiments.study.file import parse_study
from slipscale.experiments.study.levels import Levels
from slipscale.experiments.study.tables import StimulusTable, Texture
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from slipscale.stimuli.friction_map import packed
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, made_by_plate
from slipscale.stimuli.texture import Grating
from slipscale.stimuli.textures import KINDS, PARAMETERS
from slipscale.stimuli.transient import TRIGGERS

ROOT = Path(__file__).parents[3]
#: Values of the parameters that a kind of texture needs, unless they are varied.
FIXED: dict[str, dict[str, object]] = {
    "grating": {"mean_level": 2.0, "depth_level": 0.4, "finger_speed_mm_s": 5.0},
    "transient": {"from_level": 0.5, "to_level": 2.0, "transition_s": 0.01},
    "map": {
        "black_level": 0.5,
        "white_level": 2.0,
        "pixel_mm": 1.0,
        "finger_speed_mm_s": 50.0,
        "pixels": f"'{packed((bytes(range(0, 250, 10)),))}'",
        "columns": 25,
    },
}
HEAD = """
name = "varied"
title = "One parameter varied"
vary = "{vary}"
{levels} = [{low}, {middle}, {high}]
[stimulus]
{fixed}
"""
TASKS = {
    "magnitude_estimation": "practice = 0",
    "visual_analogue_scale": "practice = 0",
    "descending_difference": "",
    "paired_comparison": "practice = 0\nrepetitions = 1",
    "similarity": "practice = 0\nrepetitions = 1",
    "same_different": "practice = 0\nrepetitions = 1",
    "limits": "series = 1\n{standard} = {low}\n{turned}",
    "identification": "practice = 0\nrepetitions = 1",
    "sorting": "repetitions = 1",
    "category_scale": "practice = 0\nlabels = ['little', 'much']",
    "constant_stimuli": "practice = 0\nrepetitions = 1\n{standard} = {middle}",
    "difference_threshold": "rule = 'weighted'\nscale = 'linear'\nsteps_up = [{step}]\n{tracks}",
    "difference_threshold#quest": "rule = 'quest_plus'\nquest_levels = 4\n{tracks}",
    "oddity": "scale = 'linear'\nsteps_up = [{step}]\n{tracks}",
    "matching": "practice = 0\nrepetitions = 1\n{turned}\n{nearest} = {step}\n{furthest} = {step}",
    "ratio_to_standard": "practice = 0\n{standard} = {low}",
    "magnitude_production": "practice = 0\nnumbers = [9.0, 11.0]\n{turned}\n{standard} = {middle}",
}
# A threshold of detection is one from 0, which not every parameter can be.
FROM_ZERO = {"detection_threshold": "{detected}"}
EVERY_TASK = "spatial_period_mm"  # runs all protocols; each other parameter two of them


def study_text(field, plate=PLATE_AMPLITUDE):
    """Return a study whose levels are a parameter's, from its declaration."""
    declared = PARAMETERS[field].parameter
    q = declared.quantity(plate)
    least = max(declared.above, declared.least)
    span = min(declared.most - least, 2.0)
    kind = next(name for name, each in KINDS.items() if field in each.__dataclass_fields__)
    fixed = {name: value for name, value in FIXED[kind].items() if name != field}
    span = {"depth_level": 0.6, "position_mm": 10.0}.get(field, span)
    least = {"mean_level": 0.4, "transition_s": 0.0}.get(field, least)
    fixed["kind"] = f"'{kind}'"
    if kind == "transient" and field not in TRIGGERS:
        fixed["position_mm"] = 5.0
    if kind == "grating" and field not in ("modulation_hz", "spatial_period_mm"):
        fixed["spatial_period_mm"] = 2.0 if "eighth" in field else 1.0
    if "harmonic" in field:
        fixed["mean_level"] = 1.5
        fixed |= {field.replace("phase_deg", "share"): 0.5} if "phase" in field else {}
    elif kind == "grating":
        fixed["waveform"] = "'square'"
    low, middle, high = (round(least + share * span, 3) for share in (0.25, 0.5, 0.75))
    step = round((high - low) / 4, 4)
    of: dict[str, object] = {
        name: q.named(f"{name}_level") for name in ("standard", "lowest", "highest", "start")
    }
    of |= {name: q.named(f"{name}_start_level") for name in ("nearest", "furthest")}
    of |= {
        "low": low,
        "middle": middle,
        "step": step,
        "turned": f"{of['lowest']} = {low}\n{of['highest']} = {high}\n"
        f"{q.named('step_level')} = {step}",
        "detected": f"tracks = 1\nmost_trials = 2\npractice = 0\ncatch_trials = 1\n"
        f"{of['start']} = {step}\n{of['lowest']} = {step / 2}\n{of['highest']} = {2 * step}",
    }
    of["tracks"] = f"{of['detected']}\n{of['standard']} = {low}"
    head = HEAD.format(
        vary=plate.named(field),
        levels=q.named("levels"),
        high=high,
        fixed="\n".join(f"{plate.named(name)} = {value}" for name, value in fixed.items()),
        **of,
    )
    tasks = []
    other = list(TASKS)[1 + list(PARAMETERS).index(field) % (len(TASKS) - 1)]
    chosen = list(TASKS) if field == EVERY_TASK else ["magnitude_estimation", other]
    chosen += FROM_ZERO if field == "depth_level" else {}
    for name in chosen:
        options = (TASKS | FROM_ZERO)[name]
        protocol, _, label = name.partition("#")
        given = options.format(**of)
        if protocol == "matching":
            given += f"\n{q.named('reference_levels')} = [{middle}]"
        tasks.append(
            f'[[tasks]]\nprotocol = "{protocol}"\n'
            + (f'label = "{label}"\n' if label else "")
            + given
        )
    sensor = TRIGGERS.get(field, "position") if kind == "transient" else ""
    return head + (f'[plate]\n{sensor} = "simulated"\n' if sensor else "") + "\n".join(tasks)


def tables(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.rglob("*_beh.tsv"))}


# Declared as their neighbours: these orders would only repeat what the others show.
ALIKE = ("fifth", "sixth", "seventh")


@pytest.fixture(params=[each for each in PARAMETERS if not each.startswith(ALIKE)])
def field(request):
    return request.param


def test_a_study_runs_is_resumed_and_read_in_the_parameters_quantity(field, plan, tmp_path):
    text = study_text(field)
    study = parse_study(text, "varied.toml")
    run = plan(text, seed=3, population=people_for(study).model_dump_json())
    undisturbed = tmp_path / "whole"
    run_simulated(undisturbed, run, "mock")
    build_dataset(undisturbed)
    whole = tables(undisturbed)
    assert len(whole) == len(study.tasks)
    q = PARAMETERS[field].parameter.quantity(PLATE_AMPLITUDE)
    header = whole["sub-01_task-magnitudeestimation_run-01_beh.tsv"].split(b"\n")[0].decode()
    assert f"\t{q.column}\tamplitude_readback_um_pp\t" in header
    lines = run.journal_path(undisturbed).read_bytes().splitlines(keepends=True)
    cut = tmp_path / "cut"
    path = run.journal_path(cut)
    path.parent.mkdir(parents=True)
    path.write_bytes(b"".join(lines[: len(lines) // 2]))
    run_simulated(cut, run, "mock")
    build_dataset(cut)
    assert tables(cut) == whole
    found = load(cut)
    assert found.quantity == q
    assert sorted(found.estimates["level"].unique()) == pytest.approx(study.levels)


def test_a_parameter_is_declared_in_one_place(field):
    assert field in Texture.model_fields
    assert field in StimulusTable.model_fields
    product = [
        path
        for folder in ("analysis", "experiments", "hardware", "stimuli")
        for path in (ROOT / folder).rglob("*.py")
        if "schema.py" not in path.name
    ]
    if field in ("duty_share", "phase_deg"):  # others are spoken of: rates and means
        naming = [p.name for p in product if re.search(rf"\b{field}\b", p.read_text("utf-8"))]
        assert naming == ["texture.py"]


def test_levels_in_volts_keep_the_plates_unit_in_the_stimulus():
    volts = made_by_plate("voltage", "V", "peak")
    made = '[quantity]\nname = "voltage"\nunit = "V"\nconvention = "peak"\n'
    text = study_text("depth_level", volts).replace(
        "[stimulus]", f"{made}[plate]\nvoltage_v_peak = 3.0\n[stimulus]"
    )
    study = parse_study(text, "varied.toml")
    assert study.quantity.column == "depth_v_peak"
    assert study.plate_quantity == volts
    assert study.varied.texture.mean_level == 2.0


@pytest.mark.parametrize(
    "old, new, said",
    [
        (
            'vary = "spatial',
            'vary = "spacial',
            "expected .*spatial_period_mm.*got 'spacial_period_",
        ),
        ("[stimulus]", "[other]", r"(?s)stimulus: expected the table(?!.*beyond)"),
        ("[0.5, 1.0, 1.5]", "[0.0, 1.0]", "spatial_period_mm is 0.0, expected above 0"),
        ("mean_um_pp = 2.0\n", "", r"stimulus\.mean_um_pp: is missing"),
        (
            "mean_um_pp",
            "spatial_period_mm = 1.0\nmean_um_pp",
            "is varied and must be omitted",
        ),
        ("depth_um_pp = 0.4", "depth_um_pp = 0.9", r"2\.9 is beyond the plate's 2\.5 µm p-p"),
        (
            "mm_s = 5.0",
            "mm_s = 60.0",
            "0.5 mm corresponds to 120 Hz.*reproduces only 19.5% of a.*film 6 ms.*at least 20%",
        ),
        (
            "mm_s = 5.0",
            "mm_s = 500.0",
            "crosses 1e.03 periods per second, but the plate",
        ),
        ("periods_mm", "period_mm", "did you mean 'spatial_periods_mm'"),
        (
            "[stimulus]",
            "[stimulus]\nduty_share = 1.5",
            r"stimulus\.duty_share: expected 0\.99 or less",
        ),
        (
            TASKS["descending_difference"] + '"descending_difference"',
            '"detection_threshold"',
            "is 0.0",
        ),
    ],
)
def test_what_cannot_be_presented_is_refused_before_the_first_question(old, new, said):
    text = study_text("spatial_period_mm")
    assert old in text
    with pytest.raises(UserError, match=said):
        parse_study(text.replace(old, new), "varied.toml")


def test_a_study_of_textures_alone_needs_no_plain_surface_except_for_what_steps_through_them():
    texture = (
        '[[textures]]\nname = "a"\nspatial_period_mm = 2.5\nmean_um_pp = 1.0\ndepth_um_pp = 1.0\n'
        "finger_speed_mm_s = 50.0\n"
    )
    head = 'name = "t"\ntitle = "T"\n' + texture
    rated = parse_study(head + '[[tasks]]\nprotocol = "magnitude_estimation"', "t.toml")
    assert rated.levels == ()
    with pytest.raises(UserError, match="neither the study nor the task lists amplitudes"):
        parse_study(head + '[[tasks]]\nprotocol = "descending_difference"', "t.toml")


def test_simulated_people_tell_14_percent_of_a_period_in_75_percent_of_choices():
    study = parse_study(study_text("spatial_period_mm"), "varied.toml")
    people = people_for(study)
    seen = curves(people)
    d_prime = (seen.mean(1.0 * 1.14) - seen.mean(1.0)) / people.noise
    assert d_prime == pytest.approx(0.6745, rel=0.02)
    rough = parse_study(
        'attribute = "roughness"\n' + study_text("spatial_period_mm"),
        "varied.toml",
    )
    falling = curves(people_for(rough))
    assert falling.mean(0.5) > falling.mean(1.0) > falling.mean(1.5)


def test_a_square_wave_with_a_duty_is_up_for_that_part_of_its_period():
    wave = Grating(
        spatial_period_mm=5.0, mean_level=1.0, depth_level=0.5, waveform="square", duty_share=0.25
    )
    assert [step.level for step in wave.envelope(50.0, 0.1)] == [1.5, 0.5, 0.5, 0.5]
    assert wave.level_at(1.24) == 1.5
    assert wave.level_at(1.26) == 0.5


def test_a_wave_in_time_is_the_same_under_a_finger_of_any_speed():
    wave = Grating(modulation_hz=10.0, mean_level=1.0, depth_level=0.5, waveform="square")
    assert wave.envelope(50.0, 0.2) == wave.envelope(5.0, 0.2)
    assert wave.loop().period_s == pytest.approx(0.1)
    with pytest.raises(UserError, match="either spatial_period_mm or modulation_hz"):
        Grating(modulation_hz=10.0, spatial_period_mm=1.0, mean_level=1.0, depth_level=0.5)


@pytest.mark.parametrize(
    "vary, levels, standard, least",
    [
        ("spatial_period_mm", "spatial_periods_mm", "mm", 0.01),
        ("depth_um_pp", "depths_um_pp", "um_pp", 0.11),
    ],
)
def test_the_plates_tolerance_holds_for_levels_in_its_own_quantity(
    vary, levels, standard, least, plan
):
    """A period is exact; of a depth at a mean of 2 µm, 5 % is 0.1 µm."""

    def checked(smallest):
        text = f"""
name = "varied"
title = "Fine differences"
vary = "{vary}"
{levels} = [0.3, 0.4]
[stimulus]
mean_um_pp = 2.0
{"depth_um_pp = 0.4" if standard == "mm" else "spatial_period_mm = 1.0"}
finger_speed_mm_s = 5.0
[[tasks]]
protocol = "constant_stimuli"
standard_{standard} = {1.0 if standard == "mm" else 0.3}
comparisons_{standard} = [{(1.0 if standard == "mm" else 0.3) + smallest}]
"""
        made = plan(text)
        check_supported(made, plate_for(made, "mock", VirtualClock()))

    checked(least)
    if standard == "um_pp":
        with pytest.raises(UserError, match=r"0\.09 .*tolerance is 0\.1 µm"):
            checked(0.09)


def test_a_level_of_a_parameter_has_no_surface_without_a_stimulus():
    """2 mm would otherwise be presented as 2 µm."""
    levels = Levels.stated({"vary": "spatial_period_mm", "levels": [2.0]})
    assert levels.surface(2.0) is None
    assert list(levels.unpresentable(("levels",), 2.0)) == []

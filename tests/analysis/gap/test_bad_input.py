"""What no log set may say, whatever the kind of machine: one clear error, never a traceback or a guess."""

from dataclasses import fields

import numpy as np
import pytest

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.logset import load_logset, logset_from_frames
from gapscope.analysis.gap.machines import parallel, read_machine, stated_encoder_step
from gapscope.models.furuta import FurutaParameters
from gapscope.models.parallel.three_prs import FLEXURES

from . import every_kind

NAN = float("nan")
CHAINS = {kind: sorted(k.keys | parallel.AXIS_KEYS) for kind, k in parallel.KINDS.items()}
# Keys of system.nominal, or of system itself, whose value is a size: it cannot be below zero.
SIZES = {
    "slider": ["nominal.mass_kg", "nominal.viscous_N_s_per_m"],
    "c_drive": [
        f"nominal.{k}" for k in ("lead_m_per_rev", "m11_kg_m2", "beta_N_m_s", "gamma_N_m_s",
                                 "delta_N_m", "eta_N_m")
    ],
    "furuta": [f"nominal.{field.name}" for field in fields(FurutaParameters)],
    **{kind: [f"nominal.{key}" for key in keys] for kind, keys in CHAINS.items()},
    "pmc": ["nominal.payload", "nominal.torque_limit", "nominal.drive.beta", "nominal.encoder_bits"],
    "pendulum": ["mass_kg", "length_m", "torque_constant_Nm_per_A", "resistance_ohm",
                 "rotor_inertia_kg_m2"],
    "serial_arm": ["nominal.time_constant_s", "nominal.inertia_s2", "nominal.delay_s"],
    "piezo_stack": ["nominal.gain_um_per_V"],
    "mm3a": ["nominal.repeatability", "nominal.law_error", "nominal.joint_3_positive.basic",
             "nominal.arm.mass_3"],
    "model_file": ["tolerance"],
}  # fmt: skip
KINDS = sorted(every_kind.KINDS)
CLOCKED = [kind for kind in KINDS if kind != "mm3a"]  # whose samples are no moves


@pytest.fixture
def read(tmp_path):
    """Machine and runs of a kind, after changes of the document and of the first table."""

    def machine_of(kind, change=None, change_table=None):
        if kind == "model_file":  # its model is looked for beside the tables
            every_kind.write(kind, tmp_path, change, change_table)
            return read_machine(load_logset(tmp_path))
        return read_machine(logset_from_frames(*every_kind.in_memory(kind, change, change_table)))

    return machine_of


def put(path, value):
    """A change of a document: ``value`` at a path of keys with dots between them."""

    def change(document):
        inside = document
        *above, last = (int(k) if k.isdigit() else k for k in path.split("."))
        for key in above:
            inside = inside[key] if isinstance(inside, list) else inside.setdefault(key, {})
        inside[last] = value

    return change


@pytest.mark.parametrize(
    "kind", ["slider", "c_drive", "furuta", "two_prr", "pmc", "pendulum", "piezo_stack"]
)
def test_every_kind_takes_the_rate_or_the_period_of_a_run(read, kind):
    def of_period(document):
        for run in document["runs"]:
            del run["rate_Hz"]
            run["period_s"] = 0.2

    assert [run.period for run in read(kind)[1]] == [run.period for run in read(kind, of_period)[1]]


@pytest.mark.parametrize("kind", KINDS)
def test_an_unknown_key_of_a_run_is_refused_for_every_kind(read, kind):
    with pytest.raises(InputError, match=r"rate_hz.*Did you mean 'rate_Hz'"):
        read(kind, put("runs.0.rate_hz", 1.0))
    with pytest.raises(InputError, match=r"runs\[0\]: unknown key 'answer'"):
        read(kind, put("runs.0.answer", ["friction.coulomb"]))


@pytest.mark.parametrize("kind", SIZES)
def test_a_nominal_value_that_no_machine_has_is_named(read, kind):
    for path in SIZES[kind]:
        for value in (-1.0, NAN, float("inf"), True, "big"):
            with pytest.raises(InputError, match=path.split(".")[-1]):
                read(kind, put(f"system.{path}", value))


@pytest.mark.parametrize("kind", CLOCKED)
@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("rate_Hz", (0, -1.0, True, "1.0", NAN, 1e9, 1e300, 1e-9, 300.0)),
        ("period_s", (0, -1.0, True, "1.0", NAN, 1e9, 1e-9, 0.003, 7.0)),
        ("start_s", (-5.0, 1e308, True, "0", NAN, float("inf"))),
        ("motion", (NAN, True, ["a"])),
    ],
)
def test_a_setting_of_a_run_that_cannot_be_is_named_for_every_kind(read, kind, key, values):
    for value in values:
        with pytest.raises(InputError, match=rf"run1\.csv.*{key}"):
            read(
                kind,
                lambda d, v=value: (d["runs"][0].pop("rate_Hz"), d["runs"][0].update({key: v})),
            )


def test_a_rate_and_a_period_that_contradict_are_refused(read):
    with pytest.raises(InputError, match=r"rate_Hz 5 and period_s 0\.1 contradict"):
        read("slider", put("runs.0.period_s", 0.1))
    assert read("slider", put("runs.0.period_s", 0.2))[1][0].period == 100


@pytest.mark.parametrize("value", [NAN, -1e-7, True, "5e-7", 2.0])
def test_an_encoder_step_that_no_encoder_has_is_refused(read, value):
    with pytest.raises(InputError, match="encoder_lsb_m"):
        read("slider", put("controller.encoder_lsb_m", value))


def test_an_encoder_step_of_nothing_states_none(tmp_path):
    change = put("controller.encoder_lsb_m", 0)
    assert stated_encoder_step(load_logset(every_kind.write("slider", tmp_path, change))) is None


@pytest.mark.parametrize("bits", ["0", "2000", "-3", "2.5", "9" * 5000])
def test_bits_that_no_encoder_has_are_refused(read, bits):
    with pytest.raises(InputError, match=r"columns\.psi_L: an encoder of"):
        read("c_drive", put("columns.psi_L", f"rad, {bits}-bit encoder"))


@pytest.mark.parametrize("kind", CLOCKED)
@pytest.mark.parametrize("size", [1e9, 1e150])
def test_a_value_beyond_any_machine_is_named_by_its_column(read, kind, size):
    names = [name for name in every_kind.table(kind) if name != "t"]
    for name in names:

        def spoil(columns, name=name):
            columns[name][17] = size

        with pytest.raises(InputError, match=rf"run1\.csv.*column {name}.*expected"):
            read(kind, change_table=spoil)


@pytest.mark.parametrize(
    "kind", ["slider", "c_drive", "furuta", "pmc", "pendulum", "piezo_stack", "serial_arm"]
)
def test_a_machine_that_never_moves_is_refused(read, kind):
    def still(columns):
        for name in columns:
            if name not in ("t", "torque_enable", "load_raw") and not name.endswith("_ref"):
                columns[name][:] = columns[name][0]

    with pytest.raises(InputError, match="never change"):
        read(kind, change_table=still)


@pytest.mark.parametrize("kind", ["slider", "c_drive", "two_prr", "pmc"])
def test_a_command_of_zeros_is_refused(read, kind):
    def idle(columns):
        for name in columns:
            if name.startswith(("force", "tau", "current")):
                columns[name][:] = 0.0

    with pytest.raises(InputError, match="every command or effort is zero"):
        read(kind, change_table=idle)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (put("controllers", {}), "controller and controllers"),
        (lambda d: (d.pop("controller"), d.update(controllers={})), "controllers is empty"),
        (put("runs.1.file", "./run1.csv"), r"table of runs\[0\], too"),
        (put("runs.1.file", "run\0.csv"), "the name of a file"),
        (put("runs.0.use", NAN), "fit or validate"),
    ],
)
def test_a_description_that_cannot_be_is_one_error(read, change, words):
    with pytest.raises(InputError, match=words) as caught:
        read("slider", change)
    assert "\n" not in str(caught.value)


def test_a_run_of_several_controllers_says_which(read):
    def open_choice(document):
        law = document.pop("controller")
        document["controllers"] = {"soft": law, "hard": law}

    with pytest.raises(InputError, match=r"runs\[0\]: no controller; expected which of hard, soft"):
        read("furuta", open_choice)


def test_each_run_of_a_rotary_pendulum_has_its_own_law(read):
    def two(document):
        law = document.pop("controller")["law"]
        document["controllers"] = {"soft": {"law": law}, "hard": {"law": law.replace("30*", "60*")}}
        document["runs"][0]["controller"], document["runs"][1]["controller"] = "soft", "hard"

    laws = [run.raw.controller[0] for run in read("furuta", two)[1]]
    assert [law.kp[1] for law in laws] == [30.0, 60.0]


def test_a_copy_of_a_fitted_table_validates_nothing():
    document = every_kind.document("slider")
    first = every_kind.table("slider", seed=1)
    copy = {name: column.copy() for name, column in first.items()}
    with pytest.raises(InputError, match=r"runs\[run2\.csv\]: its numbers are those of run1\.csv"):
        logset_from_frames(document, {"run1.csv": first, "run2.csv": copy})
    copy["q"][5] += 1e-6
    assert logset_from_frames(document, {"run1.csv": first, "run2.csv": copy}).validate


def test_stiffnesses_and_masses_of_a_chain_are_all_checked():
    """The lists above come from the readers' own keys: none is left out."""
    assert len(FLEXURES.__dict__) == sum("stiffness" in key for key in CHAINS["three_prs"])
    assert {"mass1_kg", "inertia5_kg_m2", "viscous_Nms_per_rad"} <= set(CHAINS["two_prr"])


def test_every_set_that_is_there_is_read(shared_data, open_sets):
    folders = [p.parent for root in (shared_data, open_sets) for p in root.glob("*/logset.yaml")]
    assert len(folders) >= 14
    for folder in folders:
        runs = read_machine(load_logset(folder))[1]
        assert all(np.all(np.isfinite(run.position)) for run in runs), folder

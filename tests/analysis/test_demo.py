"""The demo's withheld effect: sealed before, opened after, and never in the log set."""

import hashlib
from types import SimpleNamespace

import pytest
import yaml

from gapscope.analysis import blind_machine, demo

SEED = 17  # whose first case has a single effect or comes soon after


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blind")
    return demo.sealed_case(folder, SEED), folder


def diagnosed(verdict, *ids):
    return SimpleNamespace(
        verdict=SimpleNamespace(verdict=verdict),
        to_json=lambda: {"effects": [{"id": effect} for effect in ids]},
    )


def test_the_answer_that_is_opened_is_the_one_that_was_sealed(case):
    sealed, folder = case
    assert not (folder / "answer.json").exists()
    opened = sealed.open(folder)
    assert hashlib.sha256(opened.read_bytes()).hexdigest() == sealed.seal
    assert (folder / "sealed.sha256").read_text().startswith(sealed.seal)


def test_the_log_set_does_not_hold_the_answer(case):
    sealed, _ = case
    (effect,) = sealed.answer["answer"]
    text = (sealed.logset / "logset.yaml").read_text()
    assert "answer" not in yaml.safe_load(text)
    assert effect not in text


def test_the_case_is_the_first_of_its_seed_with_one_effect(case):
    sealed, _ = case
    index = sealed.answer["index"]
    assert blind_machine.draw(SEED, index).kind == "single"
    assert all(blind_machine.draw(SEED, i).kind != "single" for i in range(index))


def test_right_means_the_true_effects_and_no_other(case):
    sealed, _ = case
    (effect,) = sealed.answer["answer"]
    assert sealed.right(diagnosed("explained", effect))
    assert not sealed.right(diagnosed("explained", effect, "load.bias"))
    assert not sealed.right(diagnosed("ambiguous", effect))
    assert not sealed.right(diagnosed("unexplained"))


def test_the_measured_log_is_left_out_where_it_is_not_at_hand(monkeypatch, tmp_path):
    monkeypatch.delenv(demo.DATA, raising=False)
    assert demo.measured_log() is None
    monkeypatch.setenv(demo.DATA, str(tmp_path))
    assert demo.measured_log() is None

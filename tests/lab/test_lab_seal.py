"""Sealed answers open with their passphrase alone, unchanged; the commitment holds the instructor to them."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stepid
from stepid import lab
from stepid.errors import InputError
from stepid.lab.seal import seal, unseal

PASSPHRASE = "correct horse battery"
RIG = lab.Rig(
    runs=(lab.RunPlan(name="1", added_mass=0.0, level=0.5), lab.RunPlan(name="2", added_mass=1.0, level=0.5)),
    hold=0.6,
    after=0.0,
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = lab.make(seed="a sentence for tests", groups=("A", "B"), effects=(), rig=RIG)
    return made.write(tmp_path / "class", passphrase=PASSPHRASE).parent


@given(st.text(max_size=200).map(lambda s: s.replace("\0", "")), st.text(min_size=8, max_size=40), st.integers(1, 300))
@settings(max_examples=6, deadline=None)
def test_any_text_comes_back(text, passphrase, padded):
    sealed = seal(text, passphrase=passphrase, padded=padded)
    assert unseal(sealed.encode(), passphrase=passphrase, where="x").rstrip(" ") == text.rstrip(" ")
    body = base64.b64decode(json.loads(sealed)["body"])
    assert len(body) % padded == 0
    assert len(text) < 8 or text.encode() not in body


def test_the_same_text_never_looks_the_same_twice():
    one, two = (json.loads(seal("x" * 64, passphrase=PASSPHRASE, padded=64)) for _ in range(2))
    assert all(one[k] != two[k] for k in ("salt", "sign", "tag", "body"))
    body = base64.b64decode(one["body"])
    assert len(set(body)) > 32  # 64 equal letters under a keystream: hardly two bytes alike


def test_a_passphrase_typed_on_another_keyboard_opens():
    sealed = seal("x", passphrase="Schl\u00fcssel", padded=8)
    assert unseal(sealed.encode(), passphrase="Schlu\u0308ssel", where="x").strip() == "x"


def test_wrong_passphrase(folder):
    for wrong in ("Correct horse battery", "correct horse battery ", "", "x" * 1000):
        with pytest.raises(InputError, match=r"answers\.sealed: the passphrase is wrong"):
            lab.open_answers(folder, passphrase=wrong)
    with pytest.raises(InputError, match="the passphrase is None"):
        lab.open_answers(folder, passphrase=None)
    assert lab.open_answers(folder / "answers.sealed", passphrase=PASSPHRASE).groups == ("A", "B")


@pytest.mark.parametrize("part", ["salt", "sign", "tag", "body"])
@pytest.mark.parametrize("at", [0, -1])
def test_a_changed_file_is_refused(folder, part, at):
    file = folder / "answers.sealed"
    values = json.loads(file.read_text())
    raw = bytearray(base64.b64decode(values[part]))
    raw[at] ^= 1
    values[part] = base64.b64encode(raw).decode()
    file.write_text(json.dumps(values))
    words = "has been changed" if part in ("tag", "body") else "passphrase is wrong"
    with pytest.raises(InputError, match=words):
        lab.open_answers(folder, passphrase=PASSPHRASE)


@pytest.mark.parametrize("keep", [0, 1, 40, 200, 2000, -10])
def test_a_file_cut_off_is_refused(folder, keep):
    file = folder / "answers.sealed"
    file.write_bytes(file.read_bytes()[:keep])
    with pytest.raises(InputError, match=r"answers\.sealed: is not a whole file"):
        lab.open_answers(folder, passphrase=PASSPHRASE)


def test_other_files_are_refused(folder, tmp_path):
    other = tmp_path / "other"
    for text in ("[]", "3", '{"format": "stepid sealed answers 1", "salt": 3}', "{}", "name = 'x'"):
        other.write_text(text)
        with pytest.raises(InputError, match="other: is not a whole file"):
            lab.open_answers(other, passphrase=PASSPHRASE)
    other.write_text('{"format": "stepid sealed answers 2"}')
    with pytest.raises(InputError, match="opens 'stepid sealed answers 1'"):
        lab.open_answers(other, passphrase=PASSPHRASE)
    with pytest.raises(InputError, match="no such file"):
        lab.open_answers(tmp_path / "nowhere", passphrase=PASSPHRASE)


def changed(answer: lab.Answer, **fields: object) -> lab.Answer:
    return lab.Answer(**{name: getattr(answer, name) for name in lab.Answer.model_fields} | fields)


def test_the_commitment_holds(folder):
    answers = lab.open_answers(folder, passphrase=PASSPHRASE)
    for group in answers.groups:
        lab.confirm(answers[group], folder / group)
        published = lab.Answer.model_validate_json(answers[group].model_dump_json(indent=2))
        lab.confirm(published, folder / group)
        assert answers[group].commitment in (folder / group / "commitment.txt").read_text()
    answer = answers["A"]
    off = {name: value * (1 + 1e-15) for name, value in answer.parameters.items()}
    for other in (
        changed(answer, effects=("free_play",)),
        changed(answer, parameters=off),
        changed(answer, nonce="x"),
        answers["B"],
    ):
        with pytest.raises(InputError, match="not the commitment to this answer"):
            lab.confirm(other, folder / "A")


def test_the_commitment_is_to_the_records_too(folder, tmp_path):
    answer = lab.open_answers(folder, passphrase=PASSPHRASE)["A"]
    record = folder / "A" / "01-1.txt"
    lines = record.read_bytes().split(b"\n")
    assert b"0.5000" in lines[40]
    lines[40] = lines[40].replace(b"0.5000", b"0.5001")
    record.write_bytes(b"\n".join(lines))
    with pytest.raises(InputError, match="records are not those"):
        lab.confirm(answer, folder / "A")
    (folder / "A" / "commitment.txt").write_text("nothing\n")
    with pytest.raises(InputError, match="no SHA-256"):
        lab.confirm(answer, folder / "A")
    (folder / "A" / "commitment.txt").unlink()
    with pytest.raises(InputError, match="no such file"):
        lab.confirm(answer, folder / "A")


def test_opened_answers_speak():
    answers = lab.make(seed="a sentence for tests", groups=("A", "B"), effects=(), rig=RIG).answers
    text = answers.summary()
    assert "nothing" in text
    assert f"base_mass = {answers['B'].parameters['base_mass']:.4g} kg" in text
    assert "<table>" in answers._repr_html_()
    assert repr(answers) == "Answers(2 groups: A, B)"
    assert repr(answers["A"]).startswith("Answer(group 'A': nothing hidden, r0 ")
    with pytest.raises(InputError, match="no answer for group 'C'"):
        answers["C"]
    assert stepid.lab.Answers.model_validate_json(answers.model_dump_json()) == answers


def test_seeds_that_can_be_guessed_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"seed 'autumn' can be guessed. Take a sentence .* 12 characters"):
        lab.make(seed="autumn", groups=("A",))
    with pytest.raises(InputError, match=r"a number of thousands of digits. Give a whole number of up to 1000 digits"):
        lab.make(seed=10**5000, groups=("A",))
    tried = lab.make(seed=1, groups=("A",), effects=(), rig=RIG)  # to try things out
    with pytest.raises(InputError, match="seed 1 can be guessed, and with it all answers"):
        tried.write(tmp_path / "class", passphrase=PASSPHRASE)
    assert not (tmp_path / "class").exists()

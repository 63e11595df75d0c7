"""What a page holds, without a browser: files in, the table, the campaign, refusals in stepid's words."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import stepid
import webapp_files as files
from stepid.errors import InputError, StepidError
from stepid.report.hand import HandMethod, by_hand
from stepid.webapp import downloads
from stepid.webapp.inbox import LARGEST_UPLOAD, safe_name
from stepid.webapp.session import Session


@pytest.fixture
def session() -> Iterator[Session]:
    opened = Session()
    yield opened
    opened.close()


def manifest_files(campaign: stepid.Campaign, folder: Path) -> dict[str, bytes]:
    where = stepid.write_campaign(campaign, folder).parent
    return {path.name: path.read_bytes() for path in where.iterdir()}


def test_recordings_become_a_campaign_and_its_parameters(session: Session) -> None:
    session.drop(files.three())
    assert session.intake.questions == ()
    assert [row.added_mass for row in session.rows] == [0.0, 0.5, 1.0]
    found = by_hand(session.campaign)
    assert isinstance(found, HandMethod)
    assert found.found.stiffness["medium"] == pytest.approx(files.PLANT["stiffness"], rel=0.01)
    assert found.found.masses["medium 0.0kg"] == pytest.approx(files.PLANT["base"], rel=0.01)


def test_masses_that_no_file_tells_are_asked_for_in_the_table(session: Session) -> None:
    session.drop(files.three(named=False))
    assert [row.added_mass for row in session.rows] == [None] * 3
    with pytest.raises(InputError, match=r"added mass of run 1, run 2, run 3 is not known\. Put it into the table"):
        _ = session.campaign
    assert session.intake.recorded is not None  # the records can be looked at all the same
    for place, typed in enumerate(("0", "0,5", 1.0)):
        session.edit(place, "added_mass", typed)
    assert [run.added_mass for run in session.campaign] == [0.0, 0.5, 1.0]


def test_a_run_can_be_left_out_and_comes_back_with_what_was_typed(session: Session) -> None:
    session.drop(files.three())
    first, second, third = (row.name for row in session.rows)
    session.edit(1, "added_mass", "0.7")
    session.choose([first, third])
    assert [run.name for run in session.campaign] == [first, third]
    assert [row.used for row in session.rows] == [True, False, True]
    with pytest.raises(InputError, match="a campaign has one run at least"):
        session.choose([])
    assert [run.name for run in session.campaign] == [first, third]
    session.choose([first, second, third])
    assert [run.added_mass for run in session.campaign] == [0.0, 0.7, 1.0]


def test_a_mass_that_is_not_known_matters_in_runs_in_use_only(session: Session) -> None:
    session.drop(files.three(named=False))
    session.edit(0, "added_mass", "0")
    session.edit(2, "added_mass", "1")
    with pytest.raises(InputError, match="the added mass of run 2 is not known"):
        _ = session.campaign
    session.choose(["run 1", "run 3"])
    assert [run.added_mass for run in session.campaign] == [0.0, 1.0]


def test_units_that_no_file_tells_are_asked_for(session: Session) -> None:
    session.drop({f"run{i}_{kg}kg.csv": files.recording(kg, units=False) for i, kg in enumerate((0.0, 0.5))})
    assert [question.key for question in session.intake.questions] == ["position_unit"]
    assert session.intake.recorded is None
    with pytest.raises(InputError, match="the files do not say all: In which unit"):
        _ = session.campaign
    with pytest.raises(InputError, match="'furlong' is no unit of the position"):
        session.answer("position_unit", "furlong")
    session.answer("position_unit", "counts")
    assert [question.key for question in session.intake.questions] == ["counts_per_meter"]
    with pytest.raises(InputError, match="Give one number"):
        session.answer("counts_per_meter", "1000;2000")
    session.answer("counts_per_meter", "1000")
    assert session.campaign["run0 0.0kg"].position.max() == pytest.approx(0.0137, rel=0.05)
    session.answer("position_unit", "cm")
    assert session.campaign["run0 0.0kg"].position.max() == pytest.approx(0.137, rel=0.05)
    session.answer("position_unit", "")  # taken back
    assert [question.key for question in session.intake.questions] == ["position_unit"]


def test_what_was_typed_and_said_stays_when_more_is_said_or_dropped(session: Session) -> None:
    two = {f"run{i}.csv": files.recording(kg, units=False) for i, kg in enumerate((0.0, 0.5))}
    session.drop(two)
    session.answer("position_unit", "mm")
    session.edit(1, "added_mass", "0.5")
    session.rename("mine")
    session.answer("time_unit", "s")
    assert [row.added_mass for row in session.rows] == [None, 0.5]
    assert session.name == "mine"
    session.drop({**two, "run2.csv": files.recording(1.0, units=False)})
    assert session.intake.questions == ()
    assert [row.added_mass for row in session.rows] == [None, 0.5, None]
    assert session.name == "mine"
    session.drop({name: files.recording(2.0, units=False) for name in two})  # other files of the same names
    assert [row.added_mass for row in session.rows] == [None, None]
    assert [question.key for question in session.intake.questions] == ["position_unit"]


def test_the_table_takes_what_a_manifest_takes(session: Session, tmp_path: Path) -> None:
    session.example()
    before = session.rows
    for key, value, said in (
        ("added_mass", "-1", "0 or more"),
        ("added_mass", "heavy", "Give a number of kg"),
        ("added_mass", "nan", "a finite number"),
        ("spring", " ", "text that is not empty"),
        ("name", "case 5", "used by more than one run"),
    ):
        with pytest.raises(InputError, match=said) as refused:
            session.edit(0, key, value)
        assert "case 1" in str(refused.value) or key == "name"
        assert session.rows == before
    broken = manifest_files(session.campaign, tmp_path / "lab")
    text = broken["campaign.toml"].decode().replace("added_mass = 1.0", "added_mass = -1.0", 1)
    with pytest.raises(InputError) as by_manifest:
        session.drop({**broken, "campaign.toml": text.encode()})
    assert str(by_manifest.value).endswith("added_mass is -1.0. It must be the mass in kg that was added, 0 or more.")


def test_the_example_unchanged_is_the_example(session: Session) -> None:
    session.example()
    lab = stepid.datasets.lab_campaign()
    assert session.campaign == lab
    session.edit(0, "name", "first")
    session.edit(0, "spring", "rusty")
    changed = session.campaign
    assert (changed[0].name, changed[0].spring) == ("first", "rusty")
    assert changed.experiments[1:] == lab.experiments[1:]


def test_a_manifest_with_its_files_reads_as_anywhere(session: Session, tmp_path: Path) -> None:
    lab = stepid.datasets.lab_campaign()[:3]
    session.drop(manifest_files(lab, tmp_path / "lab"))
    assert session.campaign == lab
    archive = zipfile.ZipFile(io.BytesIO(downloads.campaign_zip(session.campaign)))
    archive.extractall(tmp_path / "again")
    assert stepid.read_campaign(tmp_path / "again") == lab


@pytest.mark.parametrize(
    ("dropped", "said"),
    [
        ({"notes.txt": b"bring cake\n"}, "holds no table of numbers"),
        ({"picture.csv": bytes(range(256)) * 9}, "."),
        ({"empty.csv": b""}, "."),
        ({"campaign.toml": b"name = "}, "is not TOML"),
        ({"campaign.toml": b"", "other.toml": b""}, "2 manifests"),
        ({"campaign.toml": b'name = "a"\n[[experiment]]\nname = "b"\nfile = "gone.txt"\n'}, "missing"),
    ],
)
def test_bad_files_are_refused_and_the_page_goes_on(session: Session, dropped: dict[str, bytes], said: str) -> None:
    session.example()
    with pytest.raises(StepidError, match=said) as refused:
        session.drop(dropped)
    assert str(session.inbox.folder) not in str(refused.value)
    assert session.inbox.folder.name not in str(refused.value)
    assert session.rows == ()
    session.drop(files.three())
    assert len(session.campaign) == 3


def test_no_manifest_reads_a_file_of_this_computer(session: Session, tmp_path: Path) -> None:
    secret = tmp_path / "secret.csv"
    secret.write_bytes(files.recording(0.0))
    keys = 'format = "table"\ntime = 0\nposition = 1\nadded_mass = 0.0\nspring = "a"\ndamper = "b"\n'
    for path in (str(secret), f"../{tmp_path.name}/secret.csv", "/etc/passwd"):
        text = f'name = "thief"\n[[experiment]]\nname = "run"\nfile = "{path}"\n{keys}'
        with pytest.raises(InputError, match=r"absolute path|leads out"):
            session.drop({"campaign.toml": text.encode()})


def test_names_stay_in_the_folder_of_the_session(session: Session) -> None:
    names = ("../../run_0kg.csv", "C:\\temp\\run_0.5kg.csv", "/etc/run_1kg.csv", "a\0b.csv", "..", "x" * 300 + ".csv")
    assert [safe_name(name) for name in names[:3]] == ["run_0kg.csv", "run_0.5kg.csv", "run_1kg.csv"]
    assert safe_name("..") == "file"
    assert len(safe_name(names[-1])) <= 120
    assert safe_name(names[-1]).endswith(".csv")
    session.inbox.put(dict.fromkeys(names, b"1\n"))
    kept = {path.resolve().parent for path in session.inbox.folder.iterdir()}
    assert kept == {session.inbox.folder}
    with pytest.raises(InputError, match="MB are read here"):
        session.inbox.put({"large.csv": bytes(LARGEST_UPLOAD + 1)})


def test_no_dropped_file_is_lost_to_another_of_its_name(session: Session) -> None:
    session.drop(files.three())
    before = set(session.inbox.names)
    with pytest.raises(InputError, match=r"'run:1.csv' and 'run\?1.csv' would both be kept as 'run_1.csv'. Rename"):
        session.drop({"run:1.csv": b"1\n", "run?1.csv": b"2\n"})
    assert {path.name for path in session.inbox.folder.iterdir()} == before == set(session.inbox.names)
    long = [f"{'recorded in the laboratory ' * 6}{mass} g.csv" for mass in (0, 500)]
    session.inbox.put({name: name.encode() for name in long})
    assert len(session.inbox.names) == 2
    assert session.inbox.names[1].endswith("500 g.csv")


@pytest.mark.parametrize(
    "name",
    ["測" * 119 + ".csv", "🙂" * 119, "a" + "測" * 85 + ".csv", "\ud800.csv"],
    ids=["long", "emoji", "bytes", "half"],
)
def test_names_of_any_letters_can_be_kept(session: Session, name: str) -> None:
    session.inbox.put({name: b"1\n"})
    assert len(safe_name(name).encode()) <= 255
    session.drop(files.three())
    assert len(session.campaign) == 3


def test_a_full_disk_is_said_and_the_page_goes_on(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    session.drop(files.three())

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("stepid.webapp.inbox.shutil.move", full)
        with pytest.raises(InputError, match="No space left"):
            session.drop({"other.csv": b"1\n"})
    session.drop(files.three())
    assert len(session.campaign) == 3


def test_sessions_share_nothing_and_leave_nothing() -> None:
    one, two = Session(), Session(stepid.datasets.lab_campaign())
    one.drop(files.three())
    assert len(one.campaign) == 3
    assert len(two.campaign) == 10
    assert one.inbox.folder != two.inbox.folder
    two.edit(0, "name", "mine")
    assert one.rows[0].name != "mine"
    folder = one.inbox.folder
    assert len(list(folder.iterdir())) == 3
    one.close()
    assert not folder.exists()
    assert two.inbox.folder.exists()
    two.close()

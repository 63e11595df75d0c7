"""What spreadsheets store beside the text of a cell."""

from __future__ import annotations

import zipfile
from pathlib import Path

from lab_folders import write_workbook
from stepid.io.workbook import workbook_lines

ALOUD = '<rPh sb="0" eb="2"><t>{}</t></rPh><phoneticPr fontId="1"/>'


def test_how_japanese_is_read_aloud_is_no_part_of_a_name(tmp_path: Path) -> None:
    plain, told = tmp_path / "plain.xlsx", tmp_path / "told.xlsx"
    write_workbook(plain, [], ["時間", "位置"], None, [[0.0, 0.01], [1.0, 2.0]])
    with zipfile.ZipFile(plain) as book, zipfile.ZipFile(told, "w") as other:
        for name in book.namelist():
            text = book.read(name).decode()
            text = text.replace("<t>時間</t>", "<t>時間</t>" + ALOUD.format("ジカン"))
            text = text.replace("<t>位置</t>", "<r><t>位</t></r><r><t>置</t></r>" + ALOUD.format("イチ"))
            other.writestr(name, text)
    assert workbook_lines(told.read_bytes(), "told") == workbook_lines(plain.read_bytes(), "plain")
    assert workbook_lines(told.read_bytes(), "told")[0] == "時間\t位置"

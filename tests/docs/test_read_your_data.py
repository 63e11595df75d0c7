"""The page on reading data runs as it stands, and prints what it says."""

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "read-your-data.md"


def test_every_block_runs_and_says_what_it_prints(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code = "\n".join(re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL))
    exec(compile(code, PAGE.name, "exec"), {})
    promised = re.findall(r"^\s*print\(.*\)\s+# (.+)$", code, re.MULTILINE)
    assert len(promised) == 5
    printed = capsys.readouterr().out.splitlines()
    assert printed[: len(promised)] == promised

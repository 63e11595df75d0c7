"""The server: this computer only, nothing of its disk, and stepid's own words where Panel is missing."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Iterator
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest

import stepid
from stepid.cli import run
from stepid.errors import InputError, MissingPackageError
from webapp_server import serving


@pytest.fixture(scope="module")
def served() -> Iterator[Any]:
    with serving() as made:
        yield made


def test_only_this_computer_is_served(served: Any) -> None:
    listening = [one.getsockname()[0] for one in served._http._sockets.values()]
    assert listening == ["127.0.0.1"]
    with socket.socket() as other, pytest.raises(OSError, match=r"refused|unreachable"):
        other.connect(("127.0.0.2", served.port))  # another address of this very computer


def test_only_pages_of_this_server_may_talk_to_it(served: Any) -> None:
    for origin, status in (("http://evil.example", 403), (f"http://127.0.0.1:{served.port}", 101)):
        key = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"}
        request = (
            f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\nOrigin: {origin}\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: bokeh, x\r\n"
            + "".join(f"{name}: {value}\r\n" for name, value in key.items())
            + "\r\n"
        )
        with socket.create_connection(("127.0.0.1", served.port), timeout=10) as link:
            link.sendall(request.encode())
            assert link.recv(100).split()[1] == str(status).encode(), origin


@pytest.mark.parametrize(
    "path",
    [
        "/etc/passwd",
        "/../../../../etc/passwd",
        "/static/../../../../../../etc/passwd",
        "/static/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
        "/static/extensions/panel/../../../../../../../../../../etc/passwd",
        "/static/extensions/panel/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
        "/components/stepid.webapp.views.picture/Picture/_esm/../../../../../../../../../etc/passwd",
        "/components/stepid.webapp.views.picture/Picture/_stylesheets/serve.py",
        "/assets/etc/passwd",
    ],
)
def test_no_file_of_this_computer_is_served(served: Any, path: str) -> None:
    with pytest.raises(HTTPError) as refused:
        urlopen(Request(f"http://127.0.0.1:{served.port}{path}"), timeout=10)
    assert refused.value.code in {400, 403, 404, 405, 500}
    body = refused.value.read()
    assert b"root:" not in body
    assert b"Traceback" not in body


def test_a_taken_port_is_said() -> None:
    from stepid.webapp.views.serve import server

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=rf"port {port} cannot be used .*--port"):
            server(None, port)


def test_in_a_notebook_it_is_a_part_to_show() -> None:
    import panel as pn

    shown = stepid.app(stepid.datasets.lab_campaign()[:3])
    assert isinstance(shown, pn.Column)
    names = [button.label for button in shown.select(pn.widgets.Button)]
    assert {"Try the example", "Diagnose", "Cancel"} <= set(names)
    with pytest.raises(InputError, match="campaign"):
        stepid.app("lab/campaign.toml")


def test_a_missing_package_is_named_with_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "panel" or ".webapp.views" in name]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "panel", None)
    with pytest.raises(MissingPackageError, match=r'pip install "stepid\[app\]"'):
        stepid.app()
    assert run(["app", "--no-browser"]) == 2


def test_the_command_line_refuses_a_bad_campaign_before_it_serves(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["app", "nowhere.toml", "--no-browser"]) == 2
    assert "nowhere.toml" in capsys.readouterr().err
    assert run(["app", "--port", "70000"]) == 2


def test_the_command_says_where_it_is_and_ends() -> None:
    code = "import sys; from stepid.cli import run; sys.exit(run(['app', '--no-browser']))"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert line.startswith("http://127.0.0.1:")
        page = urlopen(line.split()[0], timeout=30).read().decode()
        assert "<main>" in page
        process.send_signal(2)
        assert process.wait(20) == 0

"""The server of the page: on this computer only, a session a visitor."""

from __future__ import annotations

import socket
from typing import Any

import panel as pn

from stepid.core.experiment import Campaign
from stepid.errors import InputError
from stepid.webapp.session import Session
from stepid.webapp.views.page import DESIGN, Page
from stepid.webapp.views.parts import PALETTE

ADDRESS = "127.0.0.1"
_TITLE = "stepid"
_CHECK, _LINGER = 1_000, 15_000  # ms between looks at sessions without a page, and until one is forgotten
_TEMPLATE = """
{% extends base %}
{% block postamble %}
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<style>__STYLE__</style>
{% endblock %}
{% block contents %}
<main>{{ embed(roots.page) }}</main>
{% endblock %}
"""
_BODY = "html, body { background: var(--paper); margin: 0; } body { min-height: 100vh; }"


def extended() -> None:
    """Load what the page needs of Panel."""
    pn.extension("plotly", "tabulator", "filedropper", notifications=False)


def viewed(session: Session) -> pn.Column:
    """The page of a session as a part that a notebook shows."""
    extended()
    return Page(session).view


def server(campaign: Campaign | None, port: int) -> Any:
    """Make a server, not started; `port` 0 takes a free one.

    Raises
    ------
    stepid.errors.InputError
        If the port is taken.
    """
    with socket.socket() as probe:
        try:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((ADDRESS, port))
        except (OSError, OverflowError) as error:
            raise InputError(f"port {port} cannot be used ({error})", "Give another one by --port.") from None
        port = probe.getsockname()[1]
    return pn.io.server.get_server(
        {"/": lambda: _page(campaign)},
        port=port,
        address=ADDRESS,
        websocket_origin=[f"{ADDRESS}:{port}", f"localhost:{port}"],
        title={"/": _TITLE},
        show=False,
        start=False,
        check_unused_sessions_milliseconds=_CHECK,
        unused_session_lifetime_milliseconds=_LINGER,
    )


def _page(campaign: Campaign | None) -> pn.Template:
    extended()
    session = Session(campaign)
    document = pn.state.curdoc
    context: Any = None if document is None else document.session_context
    if context is not None:
        session.watched = lambda: context.session is not None and context.session.connection_count > 0
    pn.state.on_session_destroyed(lambda _: session.close())
    template = pn.Template(_TEMPLATE.replace("__STYLE__", PALETTE + DESIGN + _BODY))
    template.add_panel("page", Page(session).view)
    return template

"""`stepid app`: the page in a browser, on this computer only."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

import stepid
from stepid.cli.terminal import console


def app(
    campaign: Annotated[
        Path | None,
        typer.Argument(metavar="[CAMPAIGN.toml]", help="To begin with: a manifest, or its folder.", show_default=False),
    ] = None,
    port: Annotated[
        int,
        typer.Option(
            "--port",
            metavar="N",
            min=0,
            max=65535,
            help="Of this computer; a free one unless said.",
            show_default=False,
        ),
    ] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
    allow_outside: Annotated[
        bool, typer.Option("--allow-outside", metavar="", help="Read files outside of the manifest's folder, too.")
    ] = False,
) -> None:
    """Open a page in the browser: drop recordings, see parameters and diagnosis, play, download a report."""
    from stepid.webapp.notebook import installed

    read = None if campaign is None else stepid.read_campaign(campaign, allow_outside=allow_outside)
    with installed():
        from stepid.webapp.views.serve import ADDRESS, server

    serving = server(read, port)
    address = f"http://{ADDRESS}:{serving.port}"
    console().print(f"{address} (Ctrl+C ends it; only this computer can see it)", markup=False)
    serving.start()
    if browser:
        serving.io_loop.add_callback(webbrowser.open, address)
    try:
        serving.io_loop.start()
    except KeyboardInterrupt:
        console().print("ended", markup=False)
    finally:
        serving.stop()

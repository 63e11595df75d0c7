"""The fifth section: an effect's knobs, and the response that they make, against a record."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import panel as pn

from stepid.core.experiment import Campaign
from stepid.core.quantities import Quantities, quantities_of
from stepid.diagnosis.result import Diagnosis
from stepid.effects import resolve
from stepid.webapp import pictures, play
from stepid.webapp.play import NONE, Bench
from stepid.webapp.views.chapter import key
from stepid.webapp.views.knob import Knob, knob
from stepid.webapp.views.parts import INPUT, button, card, grid, html, note, row, said, symbols
from stepid.webapp.views.picture import picture
from stepid.webapp.work import Work

_LEAD = "Choose an effect, turn its knobs, and see what it does to a run."
_KEY = (("measured", "measured"), ("after", "simulated"), ("left", "what is left"))


class PlayView:
    """Knobs and a picture; `started` is given the work that a long computation is."""

    def __init__(self, started: Callable[[Work[Bench], Callable[[Any], None]], None]) -> None:
        self._started = started
        self._bench: Bench | None = None
        self._filling = self._due = False
        self._run = pn.widgets.Select(
            label="Run", options=[], stylesheets=[INPUT], sizing_mode="stretch_width", max_width=260, margin=0
        )
        self._effect = pn.widgets.Select(
            label="Effect",
            options=play.effect_choices(),
            value=NONE,
            stylesheets=[INPUT],
            sizing_mode="stretch_width",
            max_width=320,
            margin=0,
        )
        self._fit = button("Fit to all runs")
        self._back = button("Reset")
        self._message = html()
        self._seen, self._left = html(), html()
        self._knobs = grid()
        self._sliders: dict[str, Knob] = {}
        self._picture = picture({}, "Measured and simulated position, what is left below.")
        self._body = pn.Column(
            row(self._run, self._effect, self._back, self._fit),
            self._seen,
            self._knobs,
            html(key(_KEY)),
            self._picture,
            self._left,
            sizing_mode="stretch_width",
            margin=0,
            visible=False,
        )
        self._run.param.watch(self._set_up, "value")
        self._effect.param.watch(self._set_up, "value")
        self._back.on_click(self._set_up)
        self._fit.on_click(self._fit_all)
        self.view = card(5, "Play", html(note(_LEAD)), self._message, self._body)

    def clear(self, why: str) -> None:
        """Show why there is nothing to play with."""
        self._bench = None
        self._body.visible = False
        self._message.object = said(why)

    def begin(self, campaign: Campaign, found: Diagnosis | None = None) -> None:
        """Fit the plant that one plays with."""
        self._message.object = said("Fitting the linear plant …")
        self._started(Work(lambda _: play.bench(campaign, found)), self._take)

    def _fit_all(self, _: object) -> None:
        at, effect = self._bench, self._effect.value
        if at is None or effect == NONE:
            return
        self._fit.disabled = True
        self._message.object = said("Fitting to all runs …")
        self._started(Work(lambda _: play.best(at, effect)), self._take)

    def _take(self, status: Any) -> None:
        self._fit.disabled = False
        if status.result is None:
            self._message.object = said(status.failure, bad=True)
            return
        self._bench = at = status.result
        self._filling = True
        names = [run.name for run in at.campaign]
        self._run.options = names
        self._run.value = self._run.value if self._run.value in names else names[0]
        if (known := list(at.fitted)) and self._effect.value == NONE:
            self._effect.value = known[-1]
        self._filling = False
        self._message.object = ""
        self._body.visible = True
        self._set_up()

    def _set_up(self, *_: object) -> None:
        """Knobs for this run and effect."""
        if self._bench is None or self._filling:
            return
        effect, say = self._effect.value, quantities_of(self._bench.campaign)
        self._fit.disabled = effect == NONE
        self._seen.object = "" if effect == NONE else f'<p class="soft">{symbols(_described(effect, say))}</p>'
        self._sliders = {k.key: self._slider(k) for k in play.knobs(self._bench, self._run.value, effect)}
        self._knobs[:] = list(self._sliders.values())
        self._draw()

    def _slider(self, one: play.Knob) -> Knob:
        slider = knob(one)
        slider.param.watch(self._turned, "value")
        return slider

    def _turned(self, _: object) -> None:
        """Draw once for all turns that came meanwhile."""
        document = pn.state.curdoc
        if document is None or document.session_context is None:
            self._draw()
        elif not self._due:
            self._due = True
            document.add_next_tick_callback(self._draw)

    def _draw(self) -> None:
        self._due = False
        at, run, effect = self._bench, self._run.value, self._effect.value
        if at is None:
            return
        model = play.turned(at, run, effect, {key: float(slider.value) for key, slider in self._sliders.items()})
        simulated, words = play.response(at, run, model)
        self._picture.figure = pictures.played(
            at.campaign[run], simulated, reach=play.reach(at, run), say=quantities_of(at.campaign)
        )
        self._left.object = said(words, bad=simulated is None)


def _described(effect: str, say: Quantities) -> str:
    one = resolve((effect,))[0]
    law = say.text("Its force: ") + f"{say.law(one.law)}. " if one.law else ""
    return f"{law}What a lab sees: {say.text(one.seen)}."

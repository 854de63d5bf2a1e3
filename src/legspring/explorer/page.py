"""The explorer's page: what is shown of a gait, and what can be changed."""

import asyncio
from collections.abc import Mapping
from functools import partial
from importlib.resources import files
from typing import Any
from urllib.parse import urlencode

import numpy as np
import panel as pn
from bokeh.document import without_document_lock
from bokeh.models import Button as Step
from bokeh.models import ColumnDataSource, CustomJS, Range1d, Slider, Toggle
from bokeh.plotting import figure

from legspring.drawing.style import COLOURS
from legspring.explorer import work
from legspring.explorer.work import Answer, Control, Sight
from legspring.kernel.walker import Floats
from legspring.model import Animal
from legspring.parallel import Processes

PUSH, PULL = COLOURS[0], COLOURS[1]
SHOWN = 8
"""Controls that are there at once; the others are chosen from a list."""
ASPECT = 1.6
"""Width of the picture by its height."""
MARKS = 9
"""Marks on the ground, a quarter of a stride apart."""
SLOW = 20.0
"""Slow motion at first."""
ENDS = ("x0", "y0", "x1", "y1")
COLUMNS: Mapping[str, tuple[str, ...]] = {
    "legs": (*ENDS, "width", "colour"),
    "free": ENDS,
    "body": ("x", "y"),
    "feet": ("x", "y"),
    "ground": ("x", "y"),
    "cursor": ("x", "y"),
    "clock": (),
    "frames": (),
}
"""What moves, each in a source of its own; then which picture is seen, and all of them."""


class Stage:
    """The animal running, and the forces of its legs through the stride, with a cursor at the instant that is seen."""

    def __init__(self) -> None:
        self.sources = {name: ColumnDataSource({one: [] for one in columns}) for name, columns in COLUMNS.items()}
        self.sources["clock"].tags = [0]
        self.scene, self.forces = self._scene(), figure(height=220, sizing_mode="stretch_width", toolbar_location=None)
        self.forces.xaxis.axis_label, self.forces.yaxis.axis_label = "time (s)", "force (m g), > 0: pushes"
        self.forces.line("x", "y", source=self.sources["cursor"], color="gray", line_dash="dashed")
        self.play = Toggle(label="run", active=True, width=70)
        self.slow = Slider(start=1.0, end=100.0, value=SLOW, step=1.0, title="slower than life, times", width=200)
        self.steps = [Step(label=label, width=50) for label in ("<", ">")]
        self._connect()

    def _scene(self) -> Any:
        ends = {axis: Range1d(-1.0, 1.0) for axis in ("x_range", "y_range")}
        scene = figure(width=int(400 * ASPECT), height=400, sizing_mode="scale_width", toolbar_location=None, **ends)
        scene.min_border = 0
        scene.axis.visible, scene.grid.visible = False, False
        where = self.sources
        scene.scatter("x", "y", source=where["ground"], marker="plus", size=8, color="silver")
        scene.segment("x0", "y0", "x1", "y1", source=where["free"], color="gray", alpha=0.3, line_width=9)
        scene.segment(
            "x0", "y0", "x1", "y1", source=where["legs"], color="colour", line_width="width", line_cap="round"
        )
        scene.scatter("x", "y", source=where["feet"], size=6, color="dimgray")
        scene.scatter("x", "y", source=where["body"], size=14, color="black")
        return scene

    def _connect(self) -> None:
        """Have the browser move the animal by itself."""
        code = (files("legspring.explorer") / "animation.js").read_text(encoding="utf-8")
        known = {**self.sources, "play": self.play, "slow": self.slow}
        run = CustomJS(args=known | {"push": PUSH, "pull": PULL}, code=code)
        self.sources["frames"].js_on_change("data", run)
        for step, way in zip(self.steps, (-1, 1), strict=True):
            # What something on the page refers to is on the page: so are the pictures.
            args = {name: self.sources[name] for name in ("clock", "frames")} | {"play": self.play, "way": way}
            code = "play.active = false; clock.show(clock.tags[0] + way)"
            step.js_on_click(CustomJS(args=args, code=code))

    def show(self, sight: Sight) -> None:
        """Show another gait."""
        frames, count = sight.frames, len(sight.frames["body"])
        ends = np.concatenate(
            [frames["hip"].reshape(-1, 2), frames["foot"].reshape(-1, 2), frames["free"].reshape(-1, 2)]
        )
        low, high = np.nanmin(ends, axis=0), np.nanmax(ends, axis=0)
        middle, half = 0.5 * (low + high), 0.6 * float(max(high[0] - low[0], ASPECT * (high[1] - low[1])))
        for axis, centre in ((self.scene.x_range, middle[0]), (self.scene.y_range, middle[1])):
            axis.start, axis.end = centre - half, centre + half
            half /= ASPECT
        data: dict[str, Any] = {}
        for name in ("hip", "foot", "free"):
            data |= {f"{name}_{axis}": frames[name][..., n].tolist() for n, axis in enumerate("xy")}
        data |= {f"body_{axis}": frames["body"][:, n].tolist() for n, axis in enumerate("xy")}
        marks = marks_of(frames["camera"], frames["ground"])
        data |= {f"mark_{axis}": marks[..., n].tolist() for n, axis in enumerate("xy")}
        strongest = float(np.max(np.abs(frames["force"])))
        data |= {"force": frames["force"].tolist(), "strongest": [strongest] * count}
        data["time"] = sight.forces["time"].tolist()
        self.sources["frames"].data = data
        self._show_forces(sight.forces)

    def _show_forces(self, forces: Mapping[str, Any]) -> None:
        lines = {str(leg): forces["force"][:, n] for n, leg in enumerate(forces["legs"])} | {"time": forces["time"]}
        if len(self.forces.renderers) == 1:
            self.lines = ColumnDataSource(lines)
            for n, leg in enumerate(forces["legs"]):
                dash = "solid" if n < len(forces["legs"]) / 2 else "dashed"
                self.forces.line(
                    "time", leg, source=self.lines, color=COLOURS[n % 3], line_width=2, line_dash=dash, legend_label=leg
                )
            self.forces.legend.orientation, self.forces.legend.background_fill_alpha = "horizontal", 0.0
            self.forces.add_layout(self.forces.legend[0], "above")
        self.lines.data = lines


def marks_of(camera: Floats, ground: Floats) -> Floats:
    """Return where marks on the ground are, seen from the camera, ``(F, MARKS, 2)``."""
    number = np.arange(MARKS) - MARKS // 2
    places = 0.25 * number[:, None] * ground
    share = (camera @ ground) / max(float(ground @ ground), 1e-12)
    moved = (np.floor(4.0 * share) / 4.0)[:, None] * ground - camera
    result: Floats = places[None] + moved[:, None]
    return result


class Explorer:
    """One visit: a gait, and what is asked of it.

    Questions are answered by a process of their own; the document is changed in the server's thread. Of several
    questions that are waiting only the last one counts.
    """

    def __init__(self, pool: Processes, animal: Animal, asked: Mapping[str, Any]) -> None:
        self.pool, self.animal, self.asked = pool, animal, dict(asked)
        self.gait, self.quiet, self.number = "", False, 0
        self.stage = Stage()
        self.facts, self.words = pn.pane.HTML(), pn.pane.Alert("searching for gaits ...", alert_type="light")
        self.branch = pn.widgets.Select(name="gait", options={})
        self.controls, self.more = pn.Column(), pn.widgets.Select(name="more to change", options=[])
        self.other, self.nearest = pn.Column(), pn.widgets.Button(name="", visible=False)
        self.known: dict[str, Control] = {}
        self.branch.param.watch(lambda event: self._ask(work.look, event.new), "value")
        self.more.param.watch(lambda event: self._choose(event.new), "value")
        self.nearest.on_click(lambda _: self._ask(work.change, self.gait, *self.at_nearest, about=self.at_nearest))
        self.at_nearest: tuple[str, float] = ("", 0.0)
        self.asked_for: dict[str, float] = {}
        self.told: dict[str, float] = {}

    def layout(self) -> Any:
        """Return the page, and search for gaits once it is there."""
        given = {name: values[-1].decode(errors="replace") for name, values in pn.state.session_args.items()}
        self.number = 1
        begin = partial(self._answer, 1, work.search, (self.animal.model_dump_json(), self.asked, given), None)
        pn.state.onload(lambda: pn.state.curdoc.add_next_tick_callback(begin))
        buttons = pn.Row(*map(pn.pane.Bokeh, (self.stage.play, *self.stage.steps, self.stage.slow)))
        moving = pn.Column(
            pn.pane.Bokeh(self.stage.scene), buttons, pn.pane.Bokeh(self.stage.forces), styles={"flex": "1 1 360px"}
        )
        side = pn.Column(
            self.words, self.nearest, self.branch, self.controls, self.more, self.other, self.facts, width=340
        )
        return pn.FlexBox(side, moving, flex_direction="row", sizing_mode="stretch_width")

    def _ask(self, function: Any, *arguments: Any, about: tuple[str, float] | None = None) -> None:
        """Ask a question, whose answer is shown when it is there."""
        if self.quiet or not arguments[0]:
            return
        self.number += 1
        pn.state.curdoc.add_next_tick_callback(partial(self._answer, self.number, function, arguments, about))

    @without_document_lock  # type: ignore[untyped-decorator]
    async def _answer(
        self, number: int, function: Any, arguments: tuple[Any, ...], about: tuple[str, float] | None
    ) -> None:
        document = pn.state.curdoc
        if number != self.number:
            return
        answer = await asyncio.get_running_loop().run_in_executor(None, self.pool.call, function, *arguments)
        if number == self.number:
            document.add_next_tick_callback(partial(self._show, answer, about))

    def _show(self, answer: Answer, about: tuple[str, float] | None) -> None:
        self.quiet = True
        try:
            self.nearest.visible = answer.sight is None and answer.nearest == answer.nearest
            if answer.words:
                self.words.object, self.words.alert_type = f"No such gait: {answer.words}.", "warning"
                if self.nearest.visible and about is not None:
                    self.at_nearest = about[0], answer.nearest
                    self.nearest.name = f"go to the nearest: {about[0]} = {answer.nearest:.5g}"
            if answer.gaits:
                self.branch.options = dict(answer.gaits)
            if answer.controls:
                self._put(answer.controls)
            if answer.sight is not None:
                self.gait = answer.sight.gait
                if not answer.words:
                    self.words.object, self.words.alert_type = self.animal.summary, "light"
                self._put_into_address(answer, about)
                self.stage.show(answer.sight)
                rows = "".join(f"<tr><th>{words}</th><td>{value}</td></tr>" for words, value in answer.sight.facts)
                self.facts.object = f"<table>{rows}</table>"
        finally:
            self.quiet = False

    def _put_into_address(self, answer: Answer, about: tuple[str, float] | None) -> None:
        """Have the address say what is shown, so that a link leads here."""
        if answer.gaits:
            self.asked_for = {name: answer.told[name] for name in (*work.ASKED, "branch") if name in answer.told}
            self.told = dict(answer.told)
        elif about is not None:
            self.told |= {about[0]: about[1]}
        elif answer.sight is not None:
            self.told = self.asked_for | {"branch": float(answer.sight.branch)}
        pn.state.location.search = "?" + urlencode({name: f"{value:.12g}" for name, value in self.told.items()})

    def _put(self, controls: tuple[Control, ...]) -> None:
        """Put the most important controls on the page, and the others into the list."""
        self.known = {one.name: one for one in controls}
        self.controls.objects = [self._slider(one) for one in controls[:SHOWN]]
        self.more.options = ["", *(one.name for one in controls[SHOWN:])]

    def _choose(self, name: str) -> None:
        self.other.objects = [self._slider(self.known[name])] if name else []

    def _slider(self, control: Control) -> Any:
        """Return a slider, with a number beside it, that changes the gait."""
        slider = pn.widgets.EditableFloatSlider(
            name=f"{control.name} ({control.unit})" if control.unit != "1" else control.name,
            value=control.value,
            start=control.low,
            end=control.high,
            step=(control.high - control.low) / 400.0,
            format="0.0000",
            width=320,
        )

        def changed(event: Any) -> None:
            self._ask(work.change, self.gait, control.name, event.new, about=(control.name, event.new))

        slider.param.watch(changed, "value")
        return slider

"""A page for this machine's browser alone: a random token in its address, and no other host's name."""

import re
import secrets
import socket
import webbrowser
from collections.abc import Callable, Mapping
from typing import Any

import panel as pn
from tornado.web import RequestHandler

from legspring.asking import open_phases
from legspring.explorer.page import Explorer
from legspring.model import Animal
from legspring.parallel import processes

ADDRESS = "127.0.0.1"
NAMES = (ADDRESS, "localhost")
"""What this machine may be called by its browser."""
WORKERS = 2
"""Processes that answer questions."""
SLOPE_DEG, HEADING = 45.0, 0.15
"""What gaits are asked for where an animal needs to be told, deg and rad."""


class Refused(RequestHandler):
    """Answers whoever calls this machine by another name, as pages of other hosts would."""

    def prepare(self) -> None:
        """Refuse."""
        self.send_error(403)


def served(page: Callable[[], Any], port: int = 0, title: str = "Legspring") -> tuple[Any, str]:
    """Return a server of a page, not started yet, and the page's address.

    Parameters
    ----------
    page
        Called for each visit; returns what Panel shows.
    port
        0 for any that is free.
    title
        Of the page.
    """
    port = port or free_port()
    token = secrets.token_urlsafe(16)
    server = pn.io.server.get_server(
        {f"/{token}": page},
        port=port,
        address=ADDRESS,
        websocket_origin=[f"{name}:{port}" for name in NAMES],
        title=title,
        use_index=False,
        show=False,
        start=False,
    )
    others = rf"(?!({'|'.join(map(re.escape, NAMES))})$).*$"
    server._tornado.add_handlers(others, [(r".*", Refused)])
    return server, f"http://{ADDRESS}:{port}/{token}"


def free_port() -> int:
    """Return the number of a port that nobody uses."""
    with socket.socket() as one:
        one.bind((ADDRESS, 0))
        number: int = one.getsockname()[1]
        return number


def explored(animal: Animal, asked: Mapping[str, float | None], port: int = 0, show: bool = True) -> None:
    """Serve the explorer of an animal until the program ends.

    Parameters
    ----------
    animal
        The animal.
    asked
        What gaits are asked for at first.
    port
        0 for any that is free.
    show
        Whether to open the browser.
    """
    wanted = {name: value for name, value in asked.items() if value is not None}
    low, high = animal.speed_law.domain_deg
    if "slope_deg" not in wanted and low < high and not animal.sagittal:
        wanted["slope_deg"] = min(max(SLOPE_DEG, low), high)
    if "heading" not in wanted and len(open_phases(animal)) > 1:
        wanted["heading"] = HEADING
    pn.extension()
    with processes(WORKERS) as pool:
        server, address = served(lambda: Explorer(pool, animal, wanted).layout(), port, f"Legspring: {animal.name}")
        print(address, flush=True)
        server.start()
        if show:
            webbrowser.open(address)
        server.io_loop.start()

"""How much is tried: as much as time allows in CI, always the same; by ``python3 dev.py fuzz`` as much as asked for."""

import pytest

from tests.fuzz.trying import OUTCOMES


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say how the examples ended."""
    if OUTCOMES:
        terminalreporter.section("outcomes of fuzzing")
        for what, count in sorted(OUTCOMES.items()):
            terminalreporter.line(f"{count:7d}  {what}")

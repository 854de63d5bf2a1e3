"""Progress bars."""

import pytest

from legspring.progress import progress_bar


def test_a_bar_goes_to_the_error_stream(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("walking", 3, show=True) as tick:
        for _ in range(3):
            tick(1)
    out, err = capsys.readouterr()
    assert out == ""
    assert "walking" in err
    assert "3/3" in err


def test_no_bar_unless_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("walking", 3, show=False) as tick:
        tick(3)
    assert capsys.readouterr() == ("", "")


CELL = """
from legspring.progress import progress_bar
with progress_bar("walking", 3, show=True, rate="gaits") as tick:
    for _ in range(3):
        tick(1)
"""


def test_a_bar_in_a_notebook() -> None:
    """One that the notebook needs nothing else for."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CELL)])
    nbclient.NotebookClient(book, timeout=120).execute()
    (output,) = book.cells[0].outputs
    assert output["output_type"] == "display_data"
    assert 'value="3" max="3"' in output["data"]["text/html"] and "gaits/s" in output["data"]["text/html"]

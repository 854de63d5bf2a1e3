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

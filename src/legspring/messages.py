"""Messages: one line each, not too long, of printable characters only."""

LONGEST = 300
"""Characters of what is said about an error."""


def one_line(message: object) -> str:
    """Return a message in one line that any terminal can show, its end left out if it is too long."""
    line = " ".join(str(message).split())
    # What would move a terminal's cursor, or is the name of a file in another encoding.
    line = "".join(sign if sign.isprintable() else ascii(sign)[1:-1] for sign in line[: LONGEST + 1])
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 4]} ..."

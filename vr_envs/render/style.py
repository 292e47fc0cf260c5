"""The look that all pictures share: size, colours and type sizes."""

from __future__ import annotations

Colour = tuple[int, int, int]

WIDTH, HEIGHT = 640, 400  # points; a picture has one pixel a point
MARGIN = 20

PAPER: Colour = (250, 249, 245)
PANEL: Colour = (255, 255, 255)
RULE: Colour = (227, 225, 217)
GREY: Colour = (128, 133, 141)
INK: Colour = (43, 49, 58)
BLUE: Colour = (47, 111, 163)
PALE_BLUE: Colour = (196, 217, 233)
ORANGE: Colour = (221, 128, 40)
PALE_ORANGE: Colour = (242, 186, 128)
RED: Colour = (196, 62, 52)
GROUND: Colour = (176, 158, 132)
PALE_GROUND: Colour = (228, 219, 203)
# all that is drawn on PAPER
INKS = (PANEL, RULE, GREY, INK, BLUE, PALE_BLUE, ORANGE, PALE_ORANGE, RED, GROUND, PALE_GROUND)

SMALL, BODY, TITLE = 11, 13, 16


def mix(first: Colour, second: Colour, share: float) -> Colour:
    """The colour `share` in [0, 1] of the way from the first to the second."""
    share = min(1.0, max(0.0, share))
    r, g, b = (round(a + (z - a) * share) for a, z in zip(first, second, strict=True))
    return r, g, b


def signed(number: str) -> str:
    """A formatted number with a proper minus sign."""
    return number.replace("-", "\N{MINUS SIGN}")

"""Pictures of two-dimensional games, drawn in code: a playfield; a car, a ship and a hovercraft from above."""

from __future__ import annotations

import math

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

Color = tuple[int, int, int]

FIELD: Color = (66, 82, 98)
GRID: Color = (77, 94, 111)
GRID_MAJOR: Color = (93, 112, 130)
TEXT: Color = (176, 192, 206)
CAR: Color = (240, 84, 62)
SHIP: Color = (240, 150, 60)
HOVERCRAFT: Color = (70, 170, 110)

_FIELD_WIDTH = 1600  # of a playfield's picture
_SCALE = 4  # drawn larger, then reduced: smooth edges


def playfield(width: float, height: float, y_down: bool) -> Image.Image:
    """A quiet dark field with a grid and its coordinates, about eight numbered lines across.

    Args:
        width, height: of the game's plane, from (0, 0), in its unit.
        y_down: whether y = 0 is at the top.

    Returns:
        RGB, 1600 wide.
    """
    zoom = _FIELD_WIDTH / width
    right, bottom = _FIELD_WIDTH, round(zoom * height)
    image = Image.new("RGB", (right, bottom), FIELD)
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(30)
    step = _round_down(width / 8)

    def row(y: float) -> float:
        return zoom * (y if y_down else height - y)

    for spacing, color in ((step / 2, GRID), (step, GRID_MAJOR)):
        for x in _lines(width, spacing):
            draw.line([(zoom * x, 0), (zoom * x, bottom)], fill=color, width=2)
        for y in _lines(height, spacing):
            draw.line([(0, row(y)), (right, row(y))], fill=color, width=2)
    for x in _lines(width, step):
        draw.text((zoom * x, bottom - 10), f"{x:g}", fill=TEXT, font=font, anchor="ms")
    for y in _lines(height, step):
        draw.text((12, row(y)), f"{y:g}", fill=TEXT, font=font, anchor="lm")
    return image


def _lines(extent: float, spacing: float) -> list[float]:
    """Multiples of the spacing between the two edges."""
    return [k * spacing for k in range(1, math.ceil(extent / spacing - 1e-9))]


def _round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a value."""
    power: float = 10.0 ** math.floor(math.log10(value) + 1e-9)
    return max(f for f in (1.0, 2.0, 5.0) if f * power <= value * (1 + 1e-9)) * power


def car_sprite(color: Color = CAR, opacity: float = 1.0) -> Image.Image:
    """A car from above that points to the right, 2 : 1.

    Args:
        color: of the body.
        opacity: 0..1.

    Returns:
        RGBA, 160 x 80.
    """
    canvas = _Canvas(160, 80)
    box = canvas.box

    def shade(factor: float) -> tuple[int, ...]:
        return tuple(min(255, round(c * factor)) for c in color)

    for x in (24, 108):  # wheels
        for y in (5, 63):
            box(x, y, x + 28, y + 12, 4, (22, 24, 28))
    box(5, 10, 155, 70, 20, shade(0.62))  # outline
    box(8, 13, 152, 67, 18, color)
    box(44, 17, 118, 63, 12, (35, 46, 58))  # glass, with the roof on it
    box(58, 19, 98, 61, 7, shade(1.12))
    box(12, 18, 18, 29, 3, (150, 20, 24))  # tail lights
    box(12, 51, 18, 62, 3, (150, 20, 24))
    box(142, 19, 149, 31, 4, (255, 244, 200))  # head lights
    box(142, 49, 149, 61, 4, (255, 244, 200))
    return canvas.picture(opacity)


def ship_sprite(color: Color = SHIP, opacity: float = 1.0) -> Image.Image:
    """A ship from above that points to the right, 4 : 1.

    Args:
        color: of the hull.
        opacity: 0..1.

    Returns:
        RGBA, 240 x 60.
    """
    canvas = _Canvas(240, 60)

    def hull(inset: float, fill: tuple[int, ...]) -> None:
        stern, bow, side = 6 + inset, 234 - 2 * inset, 8 + inset
        curve = [(165 + (bow - 165) * t, 30 - (30 - side) * (1 - t**2)) for t in np.linspace(0, 1, 30)]
        upper = [(stern, side + 5), (stern + 12, side), *curve]
        lower = [(x, 60 - y) for x, y in reversed(upper)]
        canvas.draw.polygon([(x * _SCALE, y * _SCALE) for x, y in [*upper, *lower]], fill=fill)

    hull(0, tuple(round(c * 0.55) for c in color))
    hull(3, color)
    canvas.box(22, 17, 66, 43, 3, (240, 243, 246))  # bridge
    canvas.box(56, 19, 62, 41, 3, (35, 46, 58))  # its windows
    canvas.box(84, 19, 148, 41, 3, tuple(round(c * 0.75) for c in color))  # hatches
    return canvas.picture(opacity)


def hovercraft_sprite(color: Color = HOVERCRAFT, opacity: float = 1.0) -> Image.Image:
    """A hovercraft from above that points to the right, 3 : 2.

    Args:
        color: of the deck.
        opacity: 0..1.

    Returns:
        RGBA, 180 x 120.
    """
    canvas = _Canvas(180, 120)
    box, draw = canvas.box, canvas.draw

    box(6, 8, 174, 112, 50, (32, 35, 40))  # skirt
    box(18, 20, 162, 100, 40, color)
    box(104, 36, 146, 84, 18, (35, 46, 58))  # cabin's glass
    box(84, 40, 122, 80, 10, tuple(round(c * 0.75) for c in color))
    draw.ellipse([v * _SCALE for v in (26, 28, 80, 92)], fill=(22, 24, 28))  # fan, with its hub and blades
    for k in range(4):
        a = math.pi * (k / 2 + 0.2)
        tip = (53 + 25 * math.cos(a), 60 + 29 * math.sin(a))
        draw.line([v * _SCALE for v in (53, 60, *tip)], fill=(150, 158, 166), width=5 * _SCALE)
    draw.ellipse([v * _SCALE for v in (47, 54, 59, 66)], fill=(210, 214, 218))
    box(8, 34, 20, 50, 3, (240, 243, 246))  # rudders
    box(8, 70, 20, 86, 3, (240, 243, 246))
    return canvas.picture(opacity)


class _Canvas:
    """A transparent picture, drawn larger than it will be.

    Args:
        width, height: of the picture that it becomes [px].
    """

    def __init__(self, width: int, height: int) -> None:
        self._size = (width, height)
        self._image = Image.new("RGBA", (width * _SCALE, height * _SCALE), (0, 0, 0, 0))
        self.draw = ImageDraw.Draw(self._image)

    def box(self, x0: float, y0: float, x1: float, y1: float, radius: float, fill: tuple[int, ...]) -> None:
        """A rectangle with rounded corners."""
        self.draw.rounded_rectangle([v * _SCALE for v in (x0, y0, x1, y1)], radius * _SCALE, fill=fill)

    def picture(self, opacity: float) -> Image.Image:
        """What was drawn, with a thin light rim, so that it stands out on dark ground and on lines; RGBA."""
        alpha = self._image.getchannel("A").filter(ImageFilter.GaussianBlur(2.5 * _SCALE))
        halo = Image.new("RGBA", self._image.size, (255, 255, 255, 0))
        halo.putalpha(Image.fromarray((np.minimum(np.asarray(alpha, dtype=float) * 0.8, 150)).astype(np.uint8)))
        halo.alpha_composite(self._image)
        small = halo.resize(self._size, Image.Resampling.LANCZOS)
        small.putalpha(small.getchannel("A").point(lambda a: round(a * opacity)))
        return small

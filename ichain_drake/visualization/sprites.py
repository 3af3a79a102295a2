"""Pictures of two-dimensional games, drawn in code: a playfield and a car from above."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

Color = tuple[int, int, int]

FIELD: Color = (66, 82, 98)
GRID: Color = (77, 94, 111)
GRID_MAJOR: Color = (93, 112, 130)
TEXT: Color = (176, 192, 206)
CAR: Color = (240, 84, 62)

_SCALE = 4  # drawn larger, then reduced: smooth edges


def playfield(width: int, height: int, y_down: bool, spacing: int = 50) -> Image.Image:
    """A quiet dark field with a grid and its coordinates in px.

    Args:
        width: of the game's screen [px].
        height: of the game's screen [px].
        y_down: whether y = 0 is at the top.
        spacing: of the grid [px]; every second line is stronger and numbered.

    Returns:
        RGB, of two image pixels to a game pixel.
    """
    zoom = 2
    image = Image.new("RGB", (zoom * width, zoom * height), FIELD)
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(15 * zoom)
    for major in (False, True):
        step = spacing * (2 if major else 1)
        color = GRID_MAJOR if major else GRID
        for x in range(step, width, step):
            draw.line([(zoom * x, 0), (zoom * x, zoom * height)], fill=color, width=zoom)
        for y in range(step, height, step):
            row = zoom * (y if y_down else height - y)
            draw.line([(0, row), (zoom * width, row)], fill=color, width=zoom)
    for x in range(2 * spacing, width, 2 * spacing):
        draw.text((zoom * x, zoom * (height - 5)), f"{x}", fill=TEXT, font=font, anchor="ms")
    for y in range(2 * spacing, height, 2 * spacing):
        draw.text((zoom * 6, zoom * (y if y_down else height - y)), f"{y}", fill=TEXT, font=font, anchor="lm")
    return image


def car_sprite(color: Color = CAR, opacity: float = 1.0) -> Image.Image:
    """A car from above that points to the right, 2 : 1.

    Args:
        color: of the body.
        opacity: 0..1.

    Returns:
        RGBA, 160 x 80.
    """
    image = Image.new("RGBA", (160 * _SCALE, 80 * _SCALE), (0, 0, 0, 0))
    draw = ImageDraw.Draw(image)

    def box(x0: float, y0: float, x1: float, y1: float, radius: float, fill: tuple[int, ...]) -> None:
        corners = [v * _SCALE for v in (x0, y0, x1, y1)]
        draw.rounded_rectangle(corners, radius * _SCALE, fill=fill)

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
    return _faded(_haloed(image).resize((160, 80), Image.Resampling.LANCZOS), opacity)


def _haloed(image: Image.Image) -> Image.Image:
    """The picture with a thin light rim, so that it stands out on dark ground and on lines."""
    alpha = image.getchannel("A").filter(ImageFilter.GaussianBlur(2.5 * _SCALE))
    halo = Image.new("RGBA", image.size, (255, 255, 255, 0))
    halo.putalpha(Image.fromarray((np.minimum(np.asarray(alpha, dtype=float) * 0.8, 150)).astype(np.uint8)))
    halo.alpha_composite(image)
    return halo


def _faded(image: Image.Image, opacity: float) -> Image.Image:
    image.putalpha(image.getchannel("A").point(lambda a: round(a * opacity)))
    return image

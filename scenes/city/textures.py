"""The textures of the city: small pictures, drawn by rule and by a fixed seed. Facades, roads and paving tile."""

import numpy as np
from PIL import Image, ImageDraw

CELL = 32  # pixels of one bay by one floor
GRID = 8  # bays and floors in one picture of a facade

# Strokes of the letters on the hull, in a box 4 wide and 6 high, y down.
LETTERS = {
    "A": [[(0, 6), (2, 0), (4, 6)], [(0.9, 4), (3.1, 4)]],
    "E": [[(4, 0), (0, 0), (0, 6), (4, 6)], [(0, 3), (3.2, 3)]],
    "F": [[(4, 0), (0, 0), (0, 6)], [(0, 3), (3.2, 3)]],
    "G": [[(4, 0), (0, 0), (0, 6), (4, 6), (4, 3.2), (2.2, 3.2)]],
    "I": [[(2, 0), (2, 6)]],
    "M": [[(0, 6), (0, 0), (2, 3.4), (4, 0), (4, 6)]],
    "R": [[(0, 6), (0, 0), (4, 0), (4, 3.2), (0, 3.2)], [(2, 3.2), (4, 6)]],
    "T": [[(0, 0), (4, 0)], [(2, 0), (2, 6)]],
}


def _facade(wall, seed, draw_cell):
    """A picture of GRID x GRID windows on a `wall`; `draw_cell(draw, x, y, rng)` draws each."""
    picture = Image.new("RGB", (CELL * GRID, CELL * GRID), wall)
    draw, rng = ImageDraw.Draw(picture), np.random.RandomState(seed)
    for row in range(GRID):
        for column in range(GRID):
            draw_cell(draw, column * CELL, row * CELL, rng)
    return picture


def _pick(rng, colours, shares):
    return colours[int(np.searchsorted(np.cumsum(shares), rng.random_sample() * sum(shares)))]


def _rect(draw, x, y, width, height, colour):
    draw.rectangle([x, y, x + width - 1, y + height - 1], fill=colour)


def limestone():
    """Cream stone, upright windows, a sill below each, a thin course at each floor."""
    glass = ["#3a5a75", "#2f4b64", "#4d7089", "#f4cd85"]

    def cell(draw, x, y, rng):
        _rect(draw, x, y + 30, 32, 2, "#d8c8ac")
        _rect(draw, x + 8, y + 5, 16, 21, _pick(rng, glass, [5, 4, 3, 0.5]))
        _rect(draw, x + 8, y + 5, 16, 2, "#22384c")
        _rect(draw, x + 6, y + 26, 20, 2, "#f6ecd9")

    return _facade("#eadfca", 11, cell)


def brick():
    """Terracotta with twin windows under cream lintels."""
    glass = ["#2c3f52", "#3b566b", "#f0c070"]

    def cell(draw, x, y, rng):
        _rect(draw, x, y, 32, 1, "#b4694c")
        for offset in (5, 18):
            _rect(draw, x + offset, y + 8, 9, 18, _pick(rng, glass, [5, 4, 0.35]))
        _rect(draw, x + 4, y + 5, 24, 3, "#f0dcc0")

    return _facade("#c67a5c", 12, cell)


def deco():
    """Pale piers that run all the way up, bronze spandrels between the windows."""
    glass = ["#27485a", "#35596b", "#1f3a4b", "#f3cf8c"]

    def cell(draw, x, y, rng):
        _rect(draw, x + 12, y, 20, 32, "#cdb592")
        _rect(draw, x + 12, y + 7, 20, 19, _pick(rng, glass, [4, 3, 3, 0.35]))
        _rect(draw, x + 21, y, 2, 32, "#d9c6a3")

    return _facade("#efe0c2", 13, cell)


def ribbon():
    """White bands and long windows of sea-green glass."""
    glass = ["#2f6f7d", "#3b8190", "#28616f", "#4a929c"]

    def cell(draw, x, y, rng):
        for offset in (0, 16):
            _rect(draw, x + offset, y + 11, 16, 18, _pick(rng, glass, [4, 3, 3, 2]))
            _rect(draw, x + offset, y + 11, 1, 18, "#c9d6d2")
        _rect(draw, x, y + 29, 32, 3, "#d9ded8")

    return _facade("#f4f3ec", 14, cell)


def curtain():
    """A skin of dark blue glass with thin mullions; every floor edge a little lighter."""
    glass = ["#1d4258", "#22506a", "#193a4e", "#2a6079"]

    def cell(draw, x, y, rng):
        for offset in (0, 16):
            _rect(draw, x + offset, y, 16, 32, _pick(rng, glass, [4, 3, 3, 1.5]))
            _rect(draw, x + offset, y, 1, 32, "#7fa6b4")
        _rect(draw, x, y + 27, 32, 5, "#3c6c80")
        _rect(draw, x, y + 31, 32, 1, "#9cbcc6")

    return _facade("#1d4258", 15, cell)


def mirror():
    """Almost black, for a surface that reflects, with the thin joints of its panes."""
    picture = Image.new("RGB", (64, 64), "#0c1a22")
    draw = ImageDraw.Draw(picture)
    _rect(draw, 0, 0, 64, 2, "#5f7f8a")
    _rect(draw, 0, 32, 64, 1, "#3d5a66")
    _rect(draw, 0, 0, 1, 64, "#3d5a66")
    return picture


def shops():
    """Ground floors: lit shop windows under awnings, eight shops wide."""
    picture = Image.new("RGB", (CELL * GRID, 64), "#e9dcc5")
    draw, rng = ImageDraw.Draw(picture), np.random.RandomState(16)
    awnings = ["#d9573f", "#2b7a78", "#e3a63b", "#f2efe6", "#d9573f", "#345f86", "#2b7a78", "#e3a63b"]
    for i, awning in enumerate(awnings):
        x = i * CELL
        _rect(draw, x + 3, 16, 26, 44, _pick(rng, ["#f3cf93", "#32485a", "#40586a"], [3, 3, 2]))
        _rect(draw, x + 15, 22, 2, 38, "#2a3742")
        _rect(draw, x + 2, 14, 28, 10, awning)
        _rect(draw, x + 2, 22, 28, 2, "#8c7a66")
        _rect(draw, x, 60, 32, 4, "#b9a88e")
    _rect(draw, 0, 0, CELL * GRID, 4, "#cdbb9c")
    return picture


def roof():
    """A roof from above: a pale parapet, sheets of felt, some hatches."""
    picture = Image.new("RGB", (128, 128), "#f4efe6")
    draw = ImageDraw.Draw(picture)
    _rect(draw, 5, 5, 118, 118, "#bdb4a8")
    for i in range(1, 6):
        _rect(draw, 5, 5 + i * 20, 118, 1, "#aaa195")
    for x, y, width, height in ((20, 22, 18, 12), (88, 30, 12, 12), (30, 88, 12, 20)):
        _rect(draw, x, y, width, height, "#dcd5ca")
        _rect(draw, x, y + height, width, 3, "#8d867c")
    return picture


def garden():
    """A roof garden from above: a stone border, beds of two greens, a path across."""
    picture = Image.new("RGB", (128, 128), "#e6dcc8")
    draw = ImageDraw.Draw(picture)
    _rect(draw, 6, 6, 116, 116, "#7c9a50")
    for i in range(0, 116, 16):
        _rect(draw, 6 + i, 6, 8, 116, "#86a45a")
    _rect(draw, 6, 58, 116, 7, "#d8cbb2")
    _rect(draw, 80, 6, 7, 116, "#d8cbb2")
    return picture


def tram():
    """The side of a tram: coral below, a row of windows, a cream roof line."""
    picture = Image.new("RGB", (128, 32), "#e2553d")
    draw = ImageDraw.Draw(picture)
    _rect(draw, 0, 0, 128, 4, "#f5efe2")
    _rect(draw, 0, 18, 128, 3, "#f5efe2")
    for x in range(2, 128, 16):
        _rect(draw, x, 6, 12, 10, "#2b3f52")
    return picture


def paving():
    """Travertine slabs in two tones with a darker square at every fourth joint."""
    picture = Image.new("RGB", (128, 128), "#d9ccb6")
    draw, rng = ImageDraw.Draw(picture), np.random.RandomState(17)
    for row in range(4):
        for column in range(4):
            tone = _pick(rng, ["#ddd1bc", "#d5c8b1", "#e3d8c5"], [4, 3, 2])
            _rect(draw, column * 32 + 1, row * 32 + 1, 31, 31, tone)
    _rect(draw, 0, 0, 128, 10, "#b89f83")
    _rect(draw, 0, 0, 10, 128, "#b89f83")
    _rect(draw, 0, 0, 10, 10, "#8e6f57")
    return picture


def road():
    """Asphalt with edge lines and a dashed middle; the road runs up the picture."""
    picture = Image.new("RGB", (128, 128), "#5d636b")
    draw = ImageDraw.Draw(picture)
    for x in (6, 119):
        _rect(draw, x, 0, 3, 128, "#d9d6cc")
    _rect(draw, 62, 24, 4, 72, "#ecdcae")
    return picture


def hull():
    """The airship's skin: u runs from nose to tail, v once around it, from keel to keel."""
    picture = Image.new("RGB", (1024, 512), "#f5efe2")
    draw = ImageDraw.Draw(picture)
    _rect(draw, 0, 0, 60, 512, "#e2553d")
    _rect(draw, 72, 0, 10, 512, "#e2553d")
    _rect(draw, 850, 0, 174, 512, "#1f5c78")
    _rect(draw, 832, 0, 8, 512, "#1f5c78")
    # The seams of the gores, faint, and the red keel that closes the ring at v = 0 and 1.
    for i in range(12):
        draw.line([(84, round(i * 512 / 12)), (830, round(i * 512 / 12))], fill="#e6dfcf", width=2)
    _rect(draw, 0, 0, 1024, 44, "#e2553d")
    _rect(draw, 0, 468, 1024, 44, "#e2553d")
    port = _words("AFTERIMAGE", (600, 56), "#1f5c78")
    picture.paste(port, (160, 356 - 28), port)
    starboard = port.rotate(180)
    picture.paste(starboard, (160, 156 - 28), starboard)
    return picture


def _words(text, size, colour):
    """`text` in strokes on a transparent picture of `size`; drawn four times as large, for edges."""
    width, height = size[0] * 4, size[1] * 4
    picture = Image.new("RGBA", (width, height), (0, 0, 0, 0))
    draw = ImageDraw.Draw(picture)
    unit, pen = (height - 40) / 6, 30
    step = width / len(text)
    for i, letter in enumerate(text):
        for stroke in LETTERS[letter]:
            points = [(i * step + step * 0.18 + x * unit * 0.82, 20 + y * unit) for x, y in stroke]
            draw.line(points, fill=colour, width=pen, joint="curve")
            for x, y in points:
                draw.ellipse([x - pen / 2, y - pen / 2, x + pen / 2, y + pen / 2], fill=colour)
    return picture.resize(size, Image.Resampling.BOX)


def write_all(folder):
    """Draw every texture into `folder` as `<name>.png`."""
    facades = (limestone, brick, deco, ribbon, curtain, mirror, shops)
    for make in (*facades, roof, garden, tram, paving, road, hull):
        picture = make().convert("RGB").quantize(64, dither=Image.Dither.NONE)
        picture.save(folder / f"{make.__name__}.png", optimize=True)

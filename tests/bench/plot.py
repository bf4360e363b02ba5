"""Draws what cost_curves measured: the cost of a pair against megapixels, blobs and targets. Usage: plot.py curves.json cost.svg"""
import json
import math
import sys

PANELS = (("megapixels", "megapixels an image"), ("blobs", "blobs an image"), ("targets", "targets"))
SERIES = (("pair_us", "a pair, images to positions", "#c0392b"), ("read_us", "reading its two images", "#2c3e50"))
WIDTH, HEIGHT, LEFT, TOP = 300, 240, 62, 56
PANEL_STEP = WIDTH + 78


def nice_step(span):
    """A round distance between about five marks."""
    rough = span / 5
    power = 10 ** math.floor(math.log10(rough))
    return next(f * power for f in (1, 2, 5, 10) if f * power >= rough)


def text(x, y, content, anchor="middle", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" {extra}>{content}</text>'


def panel(points, title, origin_x):
    x_most = max(p["x"] for p in points) * 1.05
    y_most = max(max(p["pair_us"], p["read_us"]) for p in points) * 1.08
    at_x = lambda x: origin_x + LEFT + WIDTH * x / x_most
    at_y = lambda y: TOP + HEIGHT * (1 - y / y_most)
    parts = []
    for value in range(0, int(y_most / nice_step(y_most)) + 1):
        y = value * nice_step(y_most)
        parts.append(f'<path d="M{at_x(0):.1f} {at_y(y):.1f}h{WIDTH}" stroke="#ddd"/>')
        parts.append(text(at_x(0) - 6, at_y(y) + 4, f"{y:g}", "end"))
    for value in range(0, int(x_most / nice_step(x_most)) + 1):
        x = value * nice_step(x_most)
        parts.append(text(at_x(x), TOP + HEIGHT + 18, f"{x:g}"))
    parts.append(text(origin_x + LEFT + WIDTH / 2, TOP + HEIGHT + 38, title))
    for key, _, colour in SERIES:
        line = " ".join(f"{at_x(p['x']):.1f},{at_y(p[key]):.1f}" for p in points)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        parts += [f'<circle cx="{at_x(p["x"]):.1f}" cy="{at_y(p[key]):.1f}" r="3" fill="{colour}"/>' for p in points]
    parts.append(f'<path d="M{at_x(0):.1f} {TOP}v{HEIGHT}h{WIDTH}" fill="none" stroke="#333"/>')
    return parts


def draw(curves):
    width, height = PANEL_STEP * len(PANELS) + 10, TOP + HEIGHT + 52
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
             f'<rect width="{width}" height="{height}" fill="white"/>',
             text(LEFT, 20, "microseconds on one core, images from memory, searched all over", "start", 'font-weight="bold"')]
    x = LEFT
    for _, label, colour in SERIES:
        parts += [f'<path d="M{x} 36h24" stroke="{colour}" stroke-width="2"/>', text(x + 30, 40, label, "start")]
        x += 220
    for i, (key, title) in enumerate(PANELS):
        parts += panel(curves[key], title, i * PANEL_STEP)
    return "\n".join(parts + ["</svg>"]) + "\n"


if __name__ == "__main__":
    with open(sys.argv[1]) as curves_file:
        picture = draw(json.load(curves_file))
    with open(sys.argv[2], "w") as picture_file:
        picture_file.write(picture)

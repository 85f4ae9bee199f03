"""The pictures of the tour: its sketch, and what its press does.

python docs/tour_pictures.py
"""

import math
import sys
import tempfile
from pathlib import Path

import pinpress as pp

HERE = Path(__file__).parent / "tour"
SPEED = 60 * pp.RPM
NEAR_BOTTOM = 0.505  # s, at 60 strokes/min, under load
COINING = pp.loads.ForceStroke(heights=[0.002, 0.001, 0.0005, 0.0], forces=[0.0, 0.30e6, 0.70e6, 1.60e6])  # as in the tour

# the sketch: lengths [mm], origin and scale of the picture
CRANK, COUPLER, UPPER, LOWER = 90.0, 650.0, 300.0, 360.0
SHAFT = (750.0, -250.0)
ANGLE = math.radians(55.0)  # of the crank in the sketch
LEFT, TOP, SCALE, WIDTH, HEIGHT = 200.0, 110.0, 0.68, 930, 790

LINK, PIN, THIN, BLUE = "#2b5c8a", "#ffffff", "#7a828c", "#b3392b"


def main() -> None:
    sys.path.append(str(HERE.parents[1] / "viz"))
    from light import light  # type: ignore[import-not-found]  # a script of viz

    HERE.mkdir(exist_ok=True)
    (HERE / "sketch.svg").write_text(sketch(), encoding="utf-8")
    draft = pp.pin_table.draft(table("650"))
    (HERE / "drawn_pose.svg").write_text(draft.sketch, encoding="utf-8")
    try:
        pp.pin_table.draft(table("550"))
    except pp.PinTableError as error:
        (HERE / "does_not_meet.svg").write_text(str(error.sketch), encoding="utf-8")
    press = draft.press()
    motion = pp.cycle(press, speed=SPEED, points=720)
    loaded = pp.inverse_dynamics(press, motion, loads=[COINING])
    pp.plots.save(pp.plots.draw(motion, "position", "velocity", "acceleration"), HERE / "slide.svg")
    pp.plots.save(pp.plots.draw(loaded, "bearings"), HERE / "bearings.svg")
    with tempfile.TemporaryDirectory() as folder:
        page = pp.record(press, motion, Path(folder) / "knuckle.html", reactions=loaded, traces=[("lower", (0.0, 0.0, 0.0))])
        light(pp.video.image(page, HERE / "knuckle.png", time=NEAR_BOTTOM, size=(900, 720)))


def table(coupler: str) -> Path:
    """The tour's pin table with a coupler of this length [mm], in a file."""
    text = (HERE.parent / "tour.md").read_text(encoding="utf-8")
    shown = text.partition('```yaml title="knuckle.yaml"\n')[2].partition("```")[0]
    path = Path(tempfile.mkdtemp()) / "knuckle.yaml"
    path.write_text(shown.replace("P: 650", f"P: {coupler}"), encoding="utf-8")
    return path


def sketch() -> str:
    """The linkage at one crank angle with its dimensions, as SVG."""
    pin_p = SHAFT[0] + CRANK * math.cos(ANGLE), SHAFT[1] + CRANK * math.sin(ANGLE)
    knee = _lower_intersection((0.0, 0.0), UPPER, pin_p, COUPLER)
    pin_s = 0.0, knee[1] - math.sqrt(LOWER**2 - knee[0] ** 2)
    parts = [
        _line((0, 60), (0, -1015), THIN, 1, "8 4"),
        _rectangle((-210, pin_s[1]), (210, pin_s[1] - 360), "#8d6aa8"),
        *(_hatched(side * 225, pin_s[1] - 20, side) for side in (-1, 1)),
        _ground((0.0, 0.0), 1),
        _ground(SHAFT, -1),
        _circle(SHAFT, CRANK, THIN, "4 4"),
        _line(SHAFT, pin_p, BLUE, 11),
        _line(pin_p, knee, LINK, 11),
        _line((0, 0), knee, "#2f8a57", 13),
        _line(knee, pin_s, "#2f8a57", 13),
        *(_pin(at) for at in ((0, 0), SHAFT, pin_p, knee, pin_s)),
        _label((-38, -8), "U"),
        _label((SHAFT[0] - 32, SHAFT[1] - 8), "O"),
        _label((pin_p[0] + 22, pin_p[1] + 16), "P"),
        _label((knee[0] + 62, knee[1] - 38), "K (C)"),
        _label((24, pin_s[1] - 48), "S"),
        _text((pin_p[0] + 40, SHAFT[1] + 20), "crank 90", BLUE, "start"),
        _text((0.52 * (pin_p[0] + knee[0]), 0.5 * (pin_p[1] + knee[1]) + 40), "coupler 650", LINK),
        _text((-18, 0.5 * knee[1] - 10), "upper 300", "#2f8a57", "end"),
        _text((0.5 * knee[0] + 62, 0.5 * (knee[1] + pin_s[1]) - 40), "lower 360", "#2f8a57", "start"),
        _text((0, pin_s[1] - 210), "slide 420 x 360", "#ffffff"),
        _dimension((0, 95), (SHAFT[0], 95), "750"),
        _line((SHAFT[0], 105), (SHAFT[0], SHAFT[1]), THIN, 1),
        _dimension((985, 0), (985, SHAFT[1]), "250"),
        _line((0, 0), (1000, 0), THIN, 1),
        _line((SHAFT[0], SHAFT[1]), (1000, SHAFT[1]), THIN, 1),
        _axes((620, -940)),
        _turning(),
    ]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="17">'
    arrow = (
        '<defs><marker id="arrow" markerWidth="9" markerHeight="8" refX="8" refY="4" orient="auto-start-reverse">'
        f'<path d="M0,0 L9,4 L0,8 z" fill="{THIN}"/></marker></defs><rect width="100%" height="100%" fill="white"/>'
    )
    return "\n".join([head, arrow, *parts, "</svg>", ""])


def _lower_intersection(one: tuple[float, float], radius: float, other: tuple[float, float], far: float) -> tuple[float, float]:
    distance = math.dist(one, other)
    foot = (radius**2 - far**2 + distance**2) / (2 * distance)
    height = math.sqrt(radius**2 - foot**2)
    x, z = (other[0] - one[0]) / distance, (other[1] - one[1]) / distance
    return one[0] + foot * x + height * z, one[1] + foot * z - height * x


def _at(point: tuple[float, float]) -> tuple[str, str]:
    return f"{LEFT + SCALE * point[0]:.1f}", f"{TOP - SCALE * point[1]:.1f}"


def _line(begin: tuple[float, float], end: tuple[float, float], colour: str, width: float, dashes: str = "", more: str = "") -> str:
    (x1, y1), (x2, y2) = _at(begin), _at(end)
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return f'<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}" stroke="{colour}" stroke-width="{width}" stroke-linecap="round"{dashed}{more}/>'


def _circle(centre: tuple[float, float], radius: float, colour: str, dashes: str) -> str:
    x, y = _at(centre)
    return f'<circle cx="{x}" cy="{y}" r="{SCALE * radius:.1f}" fill="none" stroke="{colour}" stroke-dasharray="{dashes}"/>'


def _pin(at: tuple[float, float]) -> str:
    x, y = _at(at)
    return f'<circle cx="{x}" cy="{y}" r="8" fill="{PIN}" stroke="#222" stroke-width="2.5"/>'


def _rectangle(upper_left: tuple[float, float], lower_right: tuple[float, float], colour: str) -> str:
    x, y = _at(upper_left)
    width, height = SCALE * (lower_right[0] - upper_left[0]), SCALE * (upper_left[1] - lower_right[1])
    return f'<rect x="{x}" y="{y}" width="{width:.1f}" height="{height:.1f}" fill="{colour}" fill-opacity="0.85"/>'


def _hatched(x: float, top: float, side: int) -> str:
    """A rail of the slide's guide."""
    lines = [_line((x, top), (x, top - 330), "#222", 2)]
    lines += [_line((x, top - k * 30), (x + side * 20, top - k * 30 - 20), THIN, 1.2) for k in range(11)]
    return "\n".join(lines)


def _ground(at: tuple[float, float], side: int) -> str:
    """A bearing in the frame, above the pin (1) or below it (-1)."""
    x, z = at[0], at[1] + side * 44
    lines = [_line(at, (x - 26, z), "#222", 2), _line(at, (x + 26, z), "#222", 2), _line((x - 42, z), (x + 42, z), "#222", 2)]
    lines += [_line((x - 36 + 18 * k, z), (x - 24 + 18 * k, z + side * 14), THIN, 1.2) for k in range(5)]
    return "\n".join(lines)


def _text(at: tuple[float, float], words: str, colour: str = "#222", anchor: str = "middle") -> str:
    x, y = _at(at)
    return f'<text x="{x}" y="{y}" fill="{colour}" text-anchor="{anchor}">{words}</text>'


def _label(at: tuple[float, float], letter: str) -> str:
    x, y = _at(at)
    return f'<text x="{x}" y="{y}" font-weight="bold" font-size="20" text-anchor="middle">{letter}</text>'


def _dimension(begin: tuple[float, float], end: tuple[float, float], words: str) -> str:
    ends = ' marker-start="url(#arrow)" marker-end="url(#arrow)"'
    middle = 0.5 * (begin[0] + end[0]) + (28 if begin[0] == end[0] else 0), 0.5 * (begin[1] + end[1]) + (12 if begin[1] == end[1] else -6)
    return _line(begin, end, THIN, 1.3, more=ends) + "\n" + _text(middle, words)


def _axes(corner: tuple[float, float]) -> str:
    x, z = corner
    tip = ' marker-end="url(#arrow)"'
    parts = [_line(corner, (x + 110, z), THIN, 1.6, more=tip), _line(corner, (x, z + 110), THIN, 1.6, more=tip)]
    return "\n".join([*parts, _text((x + 130, z - 8), "x"), _text((x, z + 125), "z")])


def _turning() -> str:
    """The sense of a positive crank angle."""
    (x1, y1), (x2, y2) = (_at((SHAFT[0] + 125 * math.cos(a), SHAFT[1] + 125 * math.sin(a))) for a in (math.radians(-50), math.radians(-8)))
    radius = f"{125 * SCALE:.1f}"
    path = (
        f'<path d="M{x1},{y1} A{radius},{radius} 0 0 0 {x2},{y2}" fill="none" stroke="{THIN}" stroke-width="1.6" marker-end="url(#arrow)"/>'
    )
    return path + "\n" + _text((SHAFT[0] + 40, SHAFT[1] - 165), "crank angle, positive", "#222")


if __name__ == "__main__":
    main()

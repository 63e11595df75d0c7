"""Made-up ECP exports, laid out by hand after the description of the format: no code of the library's writer."""

import numpy as np

PERIOD = 0.0088542  # s, an uneven sample time as plants have it
NAMES = {
    "s": "Sample",
    "t": "Time",
    "c": "Commanded Pos",
    "1": "Encoder 1 Pos",
    "2": "Encoder 2 Pos",
    "3": "Encoder 3 Pos",
    "u": "Control Effort",
}
WIDTHS = {"s": 6, "t": 9}


def motion(n=300, *, period=PERIOD, level=0.5, first=1, counts=4000.0, wn=15.0, zeta=0.2):
    """Counts of a plant of second order after a step at sample `first` (closed form), and the input."""
    t = period * np.maximum(np.arange(n) - first, 0)
    wd = wn * np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * wn * t)
    x = 1 - decay * (np.cos(wd * t) + zeta * wn / wd * np.sin(wd * t))
    u = np.where(np.arange(n) >= first, level, 0.0)
    return np.rint(counts * level * x), u


def columns_of(layout, n=300, *, period=PERIOD, first_sample=0, **plant):
    """Columns by letter, with Commanded Pos lagging encoder 1 as in real exports."""
    x, u = motion(n, period=period, **plant)
    sample = first_sample + np.arange(n)
    data = {"s": sample, "t": sample * period, "1": x, "2": np.rint(0.4 * x), "3": np.zeros(n), "u": u}
    data["c"] = np.concatenate(([x[0]], np.rint(0.6 * x[1:] + 0.4 * x[:-1])))
    return {letter: data[letter] for letter in layout}


def rows_of(data):
    """Fixed-width rows without brackets and line ends; -0 where a small negative count is rounded."""
    rows = []
    for values in zip(*data.values(), strict=True):
        cells = []
        for letter, value in zip(data, values, strict=True):
            digits = {"t": 3, "u": 4}.get(letter, 0)
            cells.append(f"{value:{WIDTHS.get(letter, 16)}.{digits}f}")
        rows.append("".join(cells))
    return rows


def header_of(layout):
    return " " + "   ".join(NAMES[letter] for letter in layout).replace("Time   ", "Time     ")


def export_bytes(layout="stc1u", *, newline="\r\n", end=True, rows=None, **options):
    """A raw export: header, CR LF, bare LF, `[`, rows ending in `;`, `]`."""
    rows = list(rows_of(columns_of(layout, **options)) if rows is None else rows)
    rows[0] = "[" + rows[0][1:]
    text = header_of(layout) + newline + ("\n" if newline != "\r" else "\r") + f";{newline}".join(rows) + "]"
    return (text + (newline if end else "")).encode()


def write(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path

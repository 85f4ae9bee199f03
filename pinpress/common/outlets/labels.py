"""Places for the words of a drawing: on no line and on no other words."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from ..quantities import Array

AWAY = (5.0, 9.0, 14.0, 20.0, 28.0, 38.0, 50.0, 64.0, 82.0, 104.0, 130.0, 160.0, 200.0)  # clear distances that are tried [pixels]
WAYS = np.radians([-45, -135, 45, 135, 0, 180, -90, 90, -22.5, 22.5, -157.5, 157.5, -67.5, -112.5, 67.5, 112.5])  # y points down
LEADER = 20.0  # words farther away than this have a line to their point [pixels]
WIDE, BODY = "mwMW%@", 0.72  # letters as wide as high; the width of others for each unit of size, as in a wide font


class Labels:
    """A sheet that knows what is drawn on it; ``sheet``: (2,) its size [pixels]."""

    def __init__(self, sheet: tuple[float, float]) -> None:
        self._lines = np.zeros((int(sheet[1]), int(sheet[0])), np.int32)  # of each pixel: whether a line covers it
        self._words = np.zeros_like(self._lines)

    def line(self, corners: Array, half_width: float) -> None:
        """Keep words off a line through ``corners`` (k, 2), of a width that is drawn."""
        for begin, end in itertools.pairwise(corners):
            along = end - begin
            length = float(np.linalg.norm(along))
            across = np.array([-along[1], along[0]]) / length if length else np.zeros(2)
            for away in np.linspace(-half_width, half_width, 1 + 2 * int(np.ceil(half_width))):
                points = np.linspace(begin, end, 2 + int(2 * length)) + away * across
                columns, rows = np.clip(points, 0, np.array(self._lines.shape[::-1]) - 1).astype(int).T
                self._lines[rows, columns] = 1

    def circle(self, centre: Array, radius: float) -> None:
        """Keep words off a circle's edge."""
        turns = np.linspace(0, 2 * np.pi, max(12, int(3 * radius)))
        self.line(centre + radius * np.column_stack([np.cos(turns), np.sin(turns)]), 1.0)

    def crossed(self, begin: Array, end: Array) -> int:
        """How many pixels of other lines lie along a line, without its ends."""
        points = np.linspace(begin, end, 200)[20:-20]
        columns, rows = np.clip(points, 0, np.array(self._lines.shape[::-1]) - 1).astype(int).T
        outside = int(np.any((points < 40) | (points > np.array(self._lines.shape[::-1]) - 40)))  # pixels: its words need room
        return int(sum(self._lines[rows, np.clip(columns + k, 0, self._lines.shape[1] - 1)].sum() for k in (-4, 0, 4))) + 5000 * outside

    def place(self, point: Array, words: str, size: float) -> tuple[Array, Array | None]:
        """Place words next to a point and keep later ones off them.

        Returns:
            where the words begin on their base line (2,), and the end of a line to them from their point, None where they are close.
        """
        extent = np.array([size * sum(1.0 if letter in WIDE or ord(letter) > 0x2E80 else BODY for letter in words), 1.25 * size])
        way = np.column_stack([np.cos(WAYS), np.sin(WAYS)])
        middles = np.concatenate([point + away * way + extent / 2 * np.clip(1.5 * way, -1, 1) for away in AWAY])
        boxes = np.stack([middles - extent / 2, middles + extent / 2], axis=1)  # (candidates, low and high, 2)
        outside = np.any((boxes[:, 0] < 2) | (boxes[:, 1] > np.array(self._lines.shape[::-1]) - 2), axis=1)
        faults = _sums(self._lines, boxes, 3) + 100.0 * _sums(self._words, boxes, 2) + 1e6 * outside
        ends = np.clip(point, boxes[:, 0], boxes[:, 1])
        far = np.linalg.norm(ends - point, axis=1) > LEADER
        for k in np.nonzero((faults == 0) & far)[0]:
            columns, rows = np.linspace(point, ends[k], 200).astype(int).T
            faults[k] = 100.0 * float(self._words[rows, columns].sum())
            if faults[k] == 0:
                break  # the nearest of those with a line to their point
        best = int(np.argmin(faults))
        (left, top), (right, bottom) = np.maximum(boxes[best], 0).astype(int)
        self._words[top : bottom + 1, left : right + 1] = 1
        if far[best]:
            self.line(np.array([point, ends[best]]), 0.5)
        return boxes[best, 0] + [0.0, 0.95 * size], ends[best] if far[best] else None


def _sums(pixels: NDArray[np.int32], boxes: Array, clear: int) -> Array:
    """Sum of the pixels in each of the boxes (k, low and high, 2), with ``clear`` pixels around it."""
    table = np.pad(pixels.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    (left, top), (right, bottom) = (
        np.clip(boxes[:, side].astype(int) + way, 0, pixels.shape[::-1]).T for side, way in ((0, -clear), (1, clear + 1))
    )
    return np.asarray(table[bottom, right] - table[top, right] - table[bottom, left] + table[top, left], float)

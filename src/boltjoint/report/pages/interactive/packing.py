"""Numbers and texts as a page holds them, in few letters."""

import base64
import gzip
import json
from functools import cache

import numpy as np
from numpy.typing import NDArray


def pack(values: NDArray[np.generic], kind: str = "<f4") -> str:
    """Numbers as text: to seven digits, unless another kind is given.

    >>> pack(np.array([1.0, 2.0]))
    'AACAPwAAAEA='
    """
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()


def compress(text: str) -> str:
    """A text as base64 of its gzip, which browsers expand, the same on every run."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()


def compressed_json(content: object) -> str:
    """What JSON can hold, compressed."""
    return compress(json.dumps(content, separators=(",", ":"), allow_nan=False))


@cache
def compressed_plotly() -> str:
    """The library that draws, whole: a page needs no network."""
    # it takes a tenth of a second to import
    from plotly.offline import get_plotlyjs

    return compress(get_plotlyjs())

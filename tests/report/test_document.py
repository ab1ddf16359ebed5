import base64
import gzip
import re

import numpy as np
from page_examples import DRAWING

from boltjoint.report.pages.document import compressed_page, inline_svg


def test_drawing_keeps_only_what_it_needs():
    drawn = inline_svg(DRAWING, "a-", "Title")
    assert drawn.startswith("<svg")
    assert "who made it" not in drawn
    assert 'id="a-mark"' in drawn
    assert 'href="#a-mark"' in drawn
    assert "url(#a-frame)" in drawn
    assert "axes_1" not in drawn
    assert 'd="M 0.12 -7.00 L 1 1"' in drawn
    assert "scale(0.015625)" in drawn
    assert "max-width: 284px" in drawn


def test_compressed_page_holds_the_page_without_links_to_files(page):
    assert '<a href="structure.html">' in page
    compressed = compressed_page(page)
    data = re.search('id="page">(.*?)</script>', compressed)[1]
    uncompressed = gzip.decompress(base64.b64decode(data)).decode()
    assert "Node-to-node joint" in uncompressed
    assert "#case" in uncompressed
    assert not re.search('href="[^#]', uncompressed)
    assert len(compressed) < len(page)


def test_a_page_too_long_for_a_frame_is_reported(caplog):
    noise = np.random.default_rng(0).bytes(2_000_000).hex()
    compressed_page(f"<title>Long</title>{noise}")
    assert "the page Long is too long for a frame" in caplog.text

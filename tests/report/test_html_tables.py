import re

import pandas as pd

from boltjoint.study.tables.html import html_table


def test_numbers_of_a_column_have_the_same_decimals():
    frame = pd.DataFrame(
        {
            "force_N": [0.001, 50.0],
            "peak_frequency_Hz": [101.98984, 70.6171],
            "error_percent": [-0.0001, 12.345],
            "residual": [4.26e-8, 1e-3],
            "complete": [True, False],
            "reason": [None, "a < b"],
        }
    )
    text = html_table(frame)
    cells = [re.sub("<.*?>", "", cell) for cell in re.findall("<td.*?</td>", text)]
    assert cells[:6] == ["0.001", "102.0", "0.00", "4.26 × 10⁻⁸", "yes", "–"]
    assert cells[6:] == ["50", "70.6", "12.35", "0.001", "no", "a &lt; b"]
    assert "peak frequency (Hz)" in text


def test_repeated_entries_are_printed_once():
    frame = pd.DataFrame({"joint": ["a", "a", "b"], "force_N": [1.0, 2.0, 1.0]})
    text = html_table(frame, groups=["joint"])
    assert [re.sub("<.*?>", "", cell) for cell in re.findall("<td.*?</td>", text)] == [
        *("a", "1"),
        *("", "2"),
        *("b", "1"),
    ]


def test_headings_that_are_key_paths_may_be_broken():
    text = html_table(pd.DataFrame({"contact.chi": [1.0], "2.5_percent": [2.0], "a<b": [3.0]}))
    headings = re.findall("<th [^>]*>(.*?)</th>", text)
    assert headings == ["contact.<wbr>chi", "2.5 (%)", "a&lt;b"]

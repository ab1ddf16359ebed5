"""Sentences of the pages are short, and are counted as a reader counts them."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[2] / "docs"))
from sentences import limit, mean_length, pages, sentences


@pytest.mark.parametrize("page", pages())
def test_sentences_of_a_page_are_short_on_average(page):
    assert mean_length(page) <= limit(page)


def test_pages_that_lead_by_the_hand_have_the_lower_limit():
    assert limit("README.md") == limit("docs/tutorial.md") == limit("docs/studies.md") == 20
    assert limit("docs/theory.md") == limit("docs/accuracy.md") == 25


def test_sentences_are_counted_without_what_is_no_prose():
    page = """# Title with words

First sentence, of 2.5 words (see eq. 3). Second one:

| a table | that is left out |
|---|---|

- an item without a stop
- `code is one word` and [a link](to/a/long/address.md)

```python
x = 1.  # no words
```

$$
a = b \\tag{1}
$$

    indented code
"""
    assert [len(words) for words in sentences(page)] == [8, 2, 5, 4]

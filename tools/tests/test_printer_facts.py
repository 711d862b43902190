# SPDX-License-Identifier: MIT
"""docs/PRINTER.md: 64 facts, each with a test that is there and is run."""

import re

import pytest

from pixstep import natives

FACTS = 64
_ROW = re.compile(r"^\| (\d+) \| (.+) \| `(\w+\.(?:py|c))` `(\w+)` \|$", re.MULTILINE)
ROWS = _ROW.findall((natives.root() / "docs" / "PRINTER.md").read_text("utf-8"))


def test_all_facts_are_there_once():
    assert [int(row[0]) for row in ROWS] == list(range(1, FACTS + 1))
    assert len({row[1] for row in ROWS}) == FACTS


@pytest.mark.parametrize(("number", "fact", "file", "name"), ROWS)
def test_a_fact_has_its_test(number, fact, file, name):
    folder = natives.root() / ("tools/tests" if file.endswith(".py") else "host_tests")
    (path,) = folder.rglob(file)
    text = path.read_text("utf-8")
    begins = rf"^(?:    )?def {name}\(" if file.endswith(".py") else rf"^ *RUN_TEST\({name}\);"
    assert re.search(begins, text, re.MULTILINE), f"{number}: {fact}"

# SPDX-License-Identifier: MIT
"""The fuzzers: they find what is planted, and their corpus is kept small.

`pixstep-dev fuzz run` is the long form; ctest runs some seconds of it.
"""

import pytest

from effort import cases
from pixstep.errors import UserError
from pixstep_dev.fuzzing import campaign, corpus, defects, fuzzer, sources

EXECUTIONS = 3_000_000  # a defect is found long before
ONE_EACH = [next(d for d in defects.DEFECTS if d.target == target) for target in fuzzer.TARGETS]


@pytest.mark.usefixtures("fuzzers")
@pytest.mark.parametrize(
    "defect", cases(ONE_EACH, defects.DEFECTS), ids=lambda defect: defect.about
)
def test_a_planted_defect_is_found(defect):
    outcome, _ = campaign.plant(defect, fuzzer.FuzzLimits(EXECUTIONS))
    assert outcome.finding, f"not in {outcome.executions} executions"


@pytest.mark.usefixtures("fuzzers")
def test_a_defect_that_cannot_be_planted_is_refused(tmp_path):
    defect = sources.Defect("server", defects.FRAME, "no such text", "", "nothing")
    message = r"frame\.c: the defect 'nothing' cannot be planted: 'no such text' is there 0 times"
    with pytest.raises(UserError, match=message):
        sources.build_with(defect, tmp_path)


@pytest.mark.parametrize("target", fuzzer.TARGETS)
def test_the_corpus_is_small(target):
    inputs = corpus.read(corpus.path(target))
    assert 20 <= len(inputs) < 200
    assert corpus.path(target).stat().st_size < 100_000


def test_a_corpus_comes_back(tmp_path):
    inputs = [b"\x00", bytes(range(200)), b"\xff" * 49]
    corpus.write(tmp_path / "c.hex", inputs)
    assert sorted(corpus.read(tmp_path / "c.hex")) == sorted(inputs)
    corpus.unpack(inputs, tmp_path / "folder")
    assert sorted(corpus.pack(tmp_path / "folder")) == sorted(inputs)


def test_a_malformed_corpus_is_named(tmp_path):
    (tmp_path / "c.hex").write_text("# fine\n00ff\n\nxyz\n")
    with pytest.raises(UserError, match=r"c\.hex:4: 'xyz'"):
        corpus.read(tmp_path / "c.hex")


def test_a_run_must_end(invoke):
    assert "say when to end" in invoke("fuzz", "run", "server", status=2).output

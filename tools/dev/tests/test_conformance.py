# SPDX-License-Identifier: MIT
"""Independent Modbus clients against the real images, and the table in docs/PROTOCOL.md."""

import subprocess

import pytest

from pixstep import natives
from pixstep.board import boards
from pixstep_dev import markdown
from pixstep_dev.robustness.clients import by_libmodbus, by_mbpoll, cases, conformance

pytestmark = pytest.mark.usefixtures("simulator", "mbpoll", "libmodbus")


@pytest.fixture(scope="module")
def results():
    return conformance.run()


def test_no_case_fails(results):
    assert conformance.failures(results) == []


def test_every_function_is_asked_for_by_a_client(results):
    for case in cases.CASES:
        answers = [found[case.name] for found in results.values()]
        assert cases.OK in answers, case.name
    functions = {case.function for case in cases.CASES}
    wanted = {"01", "02", "03", "04", "05", "06", "08", "15", "16", "17", "20", "22", "23"}
    assert wanted <= functions


def test_the_document_says_the_same(results):
    path = natives.source("docs/PROTOCOL.md")
    assert markdown.check(path, "conformance", conformance.table(results)), (
        "tools/pixstep-dev docs conformance --write docs/PROTOCOL.md"
    )


def test_a_failure_is_seen(tmp_path):
    """A board that refuses what it should serve, or none at all, is a FAIL by every client."""
    with conformance.pty_board("m1284") as port:
        found = by_libmodbus.run(port, "mega")
        polled = by_mbpoll.run(port, "mega")
    for result in (found, polled):
        assert result["input registers read"].startswith(cases.FAIL)
        assert result["server id"].startswith(cases.FAIL)
        assert result["registers written"] == cases.OK


class Answering:
    """A client to whose every request the board answers with one exception, or as asked for (0)."""

    def __init__(self, code):
        self.code = code

    def c_server_id(self):
        if self.code:
            raise cases.AnsweredError(self.code)


@pytest.mark.parametrize(
    ("code", "has", "result"),
    [
        (0, {"diagnosis"}, cases.OK),
        (1, {"diagnosis"}, "FAIL: exception 1"),
        (1, set(), cases.REFUSED),
        (2, set(), "FAIL: exception 2"),
        (0, set(), "FAIL: served without its feature"),
    ],
)
def test_a_case_without_its_feature_must_be_refused(code, has, result):
    assert cases.run_list(Answering(code), frozenset(has))["server id"] == result


@pytest.mark.parametrize(
    ("text", "has", "result"),
    [
        ("exception 01", set(), cases.REFUSED),
        ("ok", set(), "FAIL: served without its feature"),
        ("exception 01", {"diagnosis"}, "FAIL: exception 01"),
    ],
)
def test_the_program_too_must_find_a_missing_feature_refused(monkeypatch, text, has, result):
    word = sum(1 << boards.feature_named(name).bit for name in has)
    done = subprocess.CompletedProcess([], 0, f"features\t{word}\nserver id\t{text}\n", "")
    monkeypatch.setattr(by_libmodbus.natives, "run", lambda _: done)
    assert by_libmodbus.run("port", "uno")["server id"] == result


def test_an_unknown_case_of_the_program_is_refused(monkeypatch):
    done = subprocess.CompletedProcess([], 0, "features\t0\nno such case\tok\n", "")
    monkeypatch.setattr(by_libmodbus.natives, "run", lambda _: done)
    with pytest.raises(by_libmodbus.UserError, match="no such case"):
        by_libmodbus.run("port", "uno")

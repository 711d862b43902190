# SPDX-License-Identifier: MIT
"""Independent Modbus clients against the real images, and the table in docs/PROTOCOL.md."""

import subprocess

import pytest

from pixstep import docs, natives
from pixstep.hostile.clients import by_libmodbus, by_mbpoll, cases, conformance

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
    assert docs.check(path, "conformance", conformance.table(results)), (
        "tools/pixstep docs conformance --write docs/PROTOCOL.md"
    )


def test_a_failure_is_seen(tmp_path):
    """A board that refuses what it should serve, or none at all, is a FAIL by every client."""
    with conformance.pty_board("uno") as port:
        found = by_libmodbus.run(port, "mega")
        polled = by_mbpoll.run(port, "mega")
    for result in (found, polled):
        assert result["input registers read"].startswith(cases.FAIL)
        assert result["server id"].startswith(cases.FAIL)
        assert result["registers written"] == cases.OK


def test_an_unknown_case_of_the_program_is_refused(monkeypatch):
    done = subprocess.CompletedProcess([], 0, "no such case\tok\n", "")
    monkeypatch.setattr(by_libmodbus.natives, "run", lambda _: done)
    with pytest.raises(by_libmodbus.UserError, match="no such case"):
        by_libmodbus.run("port", "uno")

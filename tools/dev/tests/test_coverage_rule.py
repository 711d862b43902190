# SPDX-License-Identifier: MIT
"""The rule about what the native suites reach: it must find a line that nobody reaches."""

import subprocess
from pathlib import Path

import coverage
import pytest

CORE, APP = "firmware/core/", "firmware/app/"


def line(number, count, *branches, **more):
    """Return a line as gcovr describes it."""
    return {
        "line_number": number,
        "count": count,
        "branches": [{"count": one} for one in branches],
        **more,
    }


def test_lines_and_branches_are_counted():
    lines = [line(3, 1, 2, 0), line(4, 0), line(5, 9, 1, 1), line(6, 0, **{"gcovr/excluded": True})]
    found = coverage.counted(f"{CORE}a.c", lines)
    assert found == coverage.File(f"{CORE}a.c", 3, (4,), 4, 3)
    assert found.row() == ("`firmware/core/a.c`", "2 of 3", "3 of 4 (75 %)")
    assert coverage.File("a.h", 2, (), 0, 0).row()[2] == "none"


def test_an_inline_function_is_reached_if_one_of_its_copies_is():
    found = coverage.counted(f"{CORE}a.h", [line(3, 0), line(3, 1), line(4, 0), line(4, 0)])
    assert (found.lines, found.missed) == (2, (4,))


def test_only_core_must_be_reached_completely():
    files = [coverage.File(f"{layer}a.c", 9, (2, 7), 0, 0) for layer in (CORE, APP)]
    assert coverage.unreached(files) == [
        f"firmware/core/a.c:{number}: no native suite reaches it: test it, or remove it"
        for number in (2, 7)
    ]


@pytest.fixture
def project(tmp_path, monkeypatch):
    """Return an empty project that the rule looks at."""
    for layer in (CORE, APP):
        (tmp_path / layer).mkdir(parents=True)
    monkeypatch.setattr(coverage, "ROOT", tmp_path)
    monkeypatch.setattr(coverage, "BUILD", tmp_path / "build")
    return tmp_path


SOURCE = """\
int half(int n)
{
    if (n < 0) {
        return -half(-n);
    }
    return n / 2;
}
"""


@pytest.mark.parametrize(("argument", "missed"), [("4", [4]), ("-4", [])])
def test_a_line_that_a_program_does_not_reach_is_found(project, argument, missed):
    source = project / CORE / "half.c"
    source.write_text(SOURCE)
    main = project / APP / "main.c"
    main.write_text(f"int half(int n);\nint main(void) {{ return half({argument}) == 99; }}\n")
    build = project / "build" / "firmware"
    (project / "build" / "host_tests").mkdir(parents=True)
    build.mkdir()
    for path in (source, main):
        subprocess.run(
            ["gcc", "--coverage", "-c", path, "-o", build / f"{path.stem}.o"], check=True
        )
    objects = [build / "half.o", build / "main.o"]
    subprocess.run(["gcc", "--coverage", *objects, "-o", build / "program"], check=True)
    subprocess.run([build / "program"], check=True)
    files = coverage.count(html=False)
    assert [file.name for file in files] == ["firmware/app/main.c", "firmware/core/half.c"]
    places = [complaint.split(":")[1] for complaint in coverage.unreached(files)]
    assert places == [str(number) for number in missed]
    assert coverage.uncounted(files) == []
    (project / CORE / "lost.c").touch()
    assert coverage.uncounted(files) == ["firmware/core/lost.c: no native suite is linked with it"]


def test_an_exclusion_needs_a_reason(project):
    word = "GCOVR_EXCL_" + "LINE"
    (project / CORE / "a.c").write_text(f"a(); // {word}\nb(); // {word}: the compiler adds it\n")
    assert coverage.bare_exclusions() == ["firmware/core/a.c:1: an exclusion without its reason"]


def test_a_documents_table_names_the_files_there_are(tmp_path):
    path = tmp_path / "DOC.md"
    path.write_text("| `firmware/core/old.c` | 1 of 1 | none |\n| `firmware/core/a.c` | 1 of 1 |\n")
    files = [coverage.File(f"{CORE}{name}.c", 1, (), 0, 0) for name in ("a", "new")]
    assert [complaint.split(": ")[1] for complaint in coverage.outdated(path, files)] == [
        "lacks firmware/core/new.c",
        "still names firmware/core/old.c",
    ]


def test_the_firmware_excludes_nothing():
    root = Path(coverage.__file__).parents[2]
    texts = [path.read_text() for path in (root / "firmware").rglob("*.[ch]")]
    assert texts and not any(coverage.EXCLUSION.search(text) for text in texts)

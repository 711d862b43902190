# SPDX-License-Identifier: MIT
"""The rule about features: it must find a switch whose other half does not compile or is empty."""

from pathlib import Path

import feature_builds
import features
import pytest
from common import ROOT
from feature_builds import BuildError, Maker
from features import Cost

from pixstep_dev import markdown

HEADER = """\
#ifndef FEATURE_SEEK
#define FEATURE_SEEK 1
#endif
"""
SEEK = """\
#include "build_features.h"
#if FEATURE_SEEK
int seek(void) { return 1; }
#else
%s
#endif
"""
LAYOUT = """\
#include "build_features.h"
void layout(void);
void layout(void)
{
    __asm__ volatile("\\n;layout SEEK_PLACE %c0" : : "i"(FEATURE_SEEK ? 8 : 4));
}
"""
PLACE = """\
#include "layout.h"
    .byte SEEK_PLACE
    .section .note.GNU-stack,"",%progbits
"""
MAIN = """\
#include "build_features.h"
int seek(void);
int main(void) { return FEATURE_SEEK ? seek() : 0; }
"""


@pytest.fixture
def build(tmp_path):
    """Return a function that makes a build of two sources, one with the given other half."""

    def make(other_half):
        files = {"build_features.h": HEADER, "seek.c": SEEK % other_half, "main.c": MAIN}
        files["plain.c"] = "int plain(void);\nint plain(void) { return 2; }\n"
        files["place.S"], files["layout.c"] = PLACE, LAYOUT
        layout = (
            ("gcc", "-I.", "-S", "-o", "layout.s", "layout.c"),
            (
                "cmake",
                "-DFROM=layout.s",
                "-DTO=made/layout.h",
                "-P",
                str(ROOT / "cmake/layout.cmake"),
            ),
        )
        compilations = []
        for name, text in files.items():
            (tmp_path / name).write_text(text)
        for words in layout:
            feature_builds.run(list(words), tmp_path)
        for name in files:
            if name.endswith((".c", ".S")) and name != "layout.c":
                words = ("gcc", "-Wall", "-Werror", "-I.", "-Imade", name)
                made = f"{Path(name).stem}.o"
                feature_builds.run([*words, "-c", "-o", made], tmp_path)
                compilations.append(feature_builds.Compilation(tmp_path / name, made, words))
        link = ("gcc", "-o", "image.elf", *(one.made for one in compilations))
        found = feature_builds.Build(tmp_path, tuple(compilations), link, layout)
        return Maker(found, tmp_path / "out")

    return make


def test_only_what_a_switch_changes_is_compiled_again(build, monkeypatch):
    maker = build("")
    monkeypatch.setattr(feature_builds, "LARGE_FLASH", "-Wl,--gc-sections")
    made = maker.image("FEATURE_SEEK", 0)
    assert sorted(path.name for path in made.parent.glob("*.o")) == [
        "main.c.o",
        "place.S.o",
        "seek.c.o",
    ]
    stamps = {path: path.stat().st_mtime_ns for path in made.parent.glob("*.*")}
    assert maker.image("FEATURE_SEEK", 0) == made
    assert {path: path.stat().st_mtime_ns for path in made.parent.glob("*.*")} == stamps


def test_the_assembly_knows_the_structs_of_the_other_half(build, monkeypatch):
    maker = build("")
    monkeypatch.setattr(feature_builds, "LARGE_FLASH", "-Wl,--gc-sections")
    made = maker.image("FEATURE_SEEK", 0)
    assert "#define SEEK_PLACE 4" in (made.parent / "layout/layout.h").read_text()
    assert "#define SEEK_PLACE 8" in (maker.build.folder / "made/layout.h").read_text()


def test_a_half_that_does_not_compile_is_found(build):
    with pytest.raises(BuildError, match=r"seek\.c:5:.*error"):
        build("int seek(void) { return 0 }").image("FEATURE_SEEK", 0)


def test_a_half_that_warns_is_found(build):
    with pytest.raises(BuildError, match="unused"):
        build("static int left_over;").image("FEATURE_SEEK", 0)


def test_a_switch_that_changes_nothing_is_found(build):
    with pytest.raises(BuildError, match="changes nothing"):
        build("").image("FEATURE_OTHER", 0)


def test_commands_lose_the_names_of_what_they_write():
    command = "avr-gcc -DX='\"a b\"' -MD -MT a.obj -MF a.d -o a.obj -c /x/a.c"
    assert feature_builds.plain_words(command) == ("avr-gcc", '-DX="a b"', "/x/a.c")


def test_a_switch_that_saves_nothing_is_found():
    costs = {"seek": {"uno": Cost(True, 0, 0, True), "mega": Cost(False, 8, 0, True)}}
    assert features.worthless(costs) == [
        "uno: seek is worth 0 bytes of flash: its code stays without it"
    ]


ROWS = [features.Feature(0, "seek", "seeks")]


def table(monkeypatch, cost):
    """Return a document with the table of one feature of one board."""
    monkeypatch.setattr(features, "board_names", lambda: ["uno"])
    return markdown.marked(features.TABLE, features.table(ROWS, {"seek": {"uno": cost}}, "5.4.0"))


@pytest.mark.parametrize(
    ("now", "complains"),
    [
        (Cost(True, 900, 4, True), False),
        (Cost(True, 900 + features.SLACK_BYTES, 4, True), False),
        (Cost(True, 901 + features.SLACK_BYTES, 4, True), True),
        (Cost(True, 900, 5, True), True),
        (Cost(False, 900, 4, True), True),
        (Cost(True, 900, 4, False), True),
    ],
)
def test_a_table_that_is_out_of_date_is_found(monkeypatch, tmp_path, now, complains):
    path = tmp_path / "TIMING.md"
    path.write_text(table(monkeypatch, Cost(True, 900, 4, True)))
    found = features.judge({"seek": {"uno": now}}, "5.4.0", path)
    assert bool(found) == complains
    assert features.judge({"seek": {"uno": now}}, "14.2.0", path) == []
    path.write_text(table(monkeypatch, now))
    assert features.judge({"seek": {"uno": now}}, "5.4.0", path) == []


def test_every_feature_has_a_switch_and_a_bit_of_the_register():
    """The table, the defaults and the register's word are three lists of the same."""
    source = features.ROOT / "firmware"
    rows = features.read_features((source / "build_features.def").read_text())
    header = (source / "build_features.h").read_text()
    assert [row.bit for row in rows] == list(range(len(rows)))
    for row in rows:
        assert f"#ifndef {row.switch}\n" in header
        assert f"{row.switch} << {row.bit % 16}" in header


def test_a_half_that_does_not_compile_beside_the_others_is_found(build, monkeypatch):
    maker = build("int seek(void) { return 0 }")
    monkeypatch.setattr(features, "defaults", lambda _: {"FEATURE_SEEK": True})
    monkeypatch.setattr(features, "read_build", lambda *_: None)
    monkeypatch.setattr(features, "Maker", lambda *_: maker)
    (problem,) = features.turn_all(ROWS, ["uno"])
    assert problem.startswith("uno: all switches turned over: seek.c:5:")


def test_of_boards_with_the_same_defaults_one_is_turned_over(monkeypatch):
    """The quick check builds that one; the others are built by the long check."""
    monkeypatch.setattr(features, "board_names", lambda: ["large", "other", "small"])
    monkeypatch.setattr(features, "defaults", lambda board: {"FEATURE_SEEK": board != "small"})
    assert features.unlike() == ["large", "small"]

# SPDX-License-Identifier: MIT
"""The rules about modules and figures: each must find an offence planted in a small tree."""

import json
import subprocess

import circles
import common
import figures
import module_graph
import modules
import pytest
import symbols
import writable

APP, CORE, HAL = "firmware/app", "firmware/core/wire", "firmware/hal"
KEPT = "firmware/avr/hal"


@pytest.fixture
def tree(tmp_path):
    """Return a function that writes the files of a small tree and returns its root."""

    def plant(files: dict[str, str]):
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path

    return plant


def includes(root, folder="firmware"):
    """Return the graph of includes of a tree."""
    files = common.repository_files(root)
    return modules.include_graph(modules.module_files(files, folder, root), root)


def graph_of(*uses):
    """Return a graph of uses, written "user used"."""
    graph = modules.Graph()
    for use in uses:
        user, used = use.split()
        graph.note(user, used, f"{used}.h")
    return graph


def test_a_circle_of_headers_is_found_and_named(tree):
    root = tree(
        {
            f"{APP}/seek.c": '#include "app/seek.h"\n',
            f"{APP}/seek.h": '#include "app/machine.h" // struct machine\n',
            f"{APP}/machine.h": "",
            f"{APP}/machine.c": '#include "app/seek.h" // seek_poll\n',
        }
    )
    assert circles.complaints(includes(root), {}) == [
        "circle of modules: app/machine -> app/seek (app/seek.h) -> app/machine (app/machine.h)"
    ]


def test_a_header_and_its_source_are_one_module_and_no_circle(tree):
    root = tree(
        {
            f"{APP}/seek.c": '#include "app/seek.h"\n#include "app/machine.h" // faults\n',
            f"{APP}/seek.h": "#include <stdint.h>\n",
            f"{APP}/machine.h": '#include "hal/faults.def"\n',
            f"{HAL}/faults.def": "",
            f"{APP}/tests/test_seek.c": '#include "app/seek.h"\n',
        }
    )
    graph = includes(root)
    assert graph.uses == {
        f"{APP}/machine": {},
        f"{APP}/seek": {f"{APP}/machine": [f"{APP}/machine.h"]},
    }
    assert circles.complaints(graph, {}) == []


def test_a_contract_and_the_source_that_keeps_it_are_one_module(tree):
    root = tree({f"{HAL}/uart.h": "", f"{KEPT}/uart.c": "", f"{KEPT}/isr.S": ""})
    assert modules.module_of(f"{KEPT}/uart.c", root) == f"{HAL}/uart"
    assert modules.module_of(f"{KEPT}/isr.S", root) == f"{KEPT}/isr"


def test_the_compilers_marks_are_no_variables():
    found = [
        modules.Symbols("a.c", {"__gnu_lto_v1": "C", "__gnu_lto_slim": "C", "own": "B"}, set())
    ]
    assert writable.writable(found) == {"own": "a.c"}


def test_a_circle_is_named_by_a_shortest_way():
    graph = graph_of("a b", "b c", "c a", "c d", "d c", "e a")
    assert modules.knots(graph) == [["a", "b", "c", "d"]]
    assert modules.circles(graph) == [["a", "b", "c"], ["c", "d"]]


def test_a_use_in_the_table_opens_its_circle_and_no_other():
    graph = graph_of("a b", "b a", "b c", "c b")
    assert circles.complaints(graph, {("b", "a"): "why", ("c", "b"): "why"}) == []
    assert circles.complaints(graph, {("b", "a"): "why"}) == [
        "circle of modules: b -> c (c.h) -> b (b.h)"
    ]


@pytest.mark.parametrize("gone", [("a", "c"), ("c", "a"), ("b", "c")])
def test_a_row_of_the_table_that_closes_no_circle_is_an_error(gone):
    graph = graph_of("a b", "b a", "b c")
    assert circles.complaints(graph, {("b", "a"): "why", gone: "why"}) == [
        f"the table's {gone[0]} -> {gone[1]} closes no circle: remove it"
    ]


def build(root, **sources):
    """Compile a tree's sources as a build of it would; return the build's folder."""
    folder, commands = root / "build", []
    for name, path in sources.items():
        made = f"firmware/{name}.o"
        (folder / "firmware").mkdir(parents=True, exist_ok=True)
        words = ["gcc", "-fcommon", "-c", str(root / path), "-o", made]
        subprocess.run(words, cwd=folder, check=True)
        entry = {"directory": str(folder), "command": " ".join(words), "file": str(root / path)}
        commands.append(entry)
    (folder / "compile_commands.json").write_text(json.dumps(commands))
    (folder / "CMakeCache.txt").write_text("CMAKE_NM:FILEPATH=nm\n")
    return folder


def test_a_circle_of_calls_without_an_include_is_found(tree):
    root = tree(
        {
            f"{CORE}/server.c": "int data_write(int);\nint serve(void) { return data_write(1); }\n",
            f"{APP}/data.c": "int serve(void);\nint data_write(int n) { return n + serve(); }\n",
        }
    )
    graph = includes(root)
    assert circles.complaints(graph, {}) == []
    found = modules.build_symbols(build(root, s=f"{CORE}/server.c", d=f"{APP}/data.c"), root=root)
    modules.note_symbols(graph, found, root=root)
    assert circles.complaints(graph, {}) == [
        "circle of modules: app/data -> core/wire/server (serve()) -> app/data (data_write())"
    ]


def test_a_call_through_a_port_uses_the_port(tree):
    port = "firmware/core/base/port.h"
    root = tree(
        {
            port: "int data_write(int value);\n",
            f"{CORE}/server.h": '#include "base/port.h" // data_write\n',
            f"{CORE}/server.c": "",
            f"{APP}/data.c": '#include "wire/server.h" // serve\n#include "base/port.h" // own\n',
        }
    )
    found = [
        modules.parse_symbols(f"{CORE}/server.c", "         U data_write\n0000 T serve\n"),
        modules.parse_symbols(f"{APP}/data.c", "0000 T data_write\n         U serve\n"),
    ]
    graph = includes(root)
    modules.note_symbols(graph, found, [port], root)
    assert circles.complaints(graph, {}) == []
    assert circles.bad_ports(graph, {port: "why"}, root) == []
    modules.note_symbols(graph, found, [], root)
    assert len(circles.complaints(graph, {})) == 1


def test_a_circle_of_folders_is_found(tree):
    root = tree(
        {
            f"{APP}/a/one.h": "",
            f"{APP}/a/two.h": '#include "app/b/three.h" // three\n',
            f"{APP}/b/three.h": '#include "app/a/one.h" // one\n',
        }
    )
    graph = includes(root)
    assert circles.complaints(graph, {}) == []
    assert circles.complaints(circles.folder_graph(graph), {}) == [
        "circle of modules: app/a -> app/b (app/b/three.h) -> app/a (app/a/one.h)"
    ]


def test_assembly_belongs_to_the_module_that_its_comment_names(tree):
    root = tree(
        {
            "firmware/core/clock/grid.h": "",
            "firmware/avr/core/grid_steps.S": "; SPDX\n; The assembly half of grid.h.\n",
            "firmware/avr/core/lost.S": "; The half of nothing.\n    nop ; grid.h\n",
        }
    )
    assert modules.module_of("firmware/avr/core/grid_steps.S", root) == "firmware/core/clock/grid"
    with pytest.raises(modules.ModuleError, match=r"lost\.S: its comment names no file"):
        modules.module_of("firmware/avr/core/lost.S", root)


def test_a_port_is_a_header_alone_that_somebody_calls(tree):
    root = tree({"a.h": "int f(int);\n", "b.h": "", "b.c": ""})
    graph = graph_of("x y")
    assert circles.bad_ports(graph, {"a.h": "", "b.h": "", "c.h": ""}, root) == [
        "the port a.h is called by nobody: remove it from the table",
        "the port b.h has a source beside it: it is a module",
        "the port c.h is gone: remove it from the table",
    ]


def test_a_build_that_was_never_made_is_not_passed_over(tree):
    root = tree({f"{APP}/data.c": "int x;\n"})
    with pytest.raises(modules.ModuleError, match="configure and build first"):
        modules.build_symbols(root / "build", root=root)
    made = build(root, data=f"{APP}/data.c")
    (made / "firmware" / "data.o").unlink()
    with pytest.raises(modules.ModuleError, match="build first"):
        modules.build_symbols(made, root=root)


def test_a_variable_that_others_can_write_is_found(tree):
    source = (
        "int zeroed; int filled = 3; static int own; int common_one;\n"
        "const int flash = 7; int *get(void) { return &own; }\n"
    )
    root = tree({f"{APP}/a.c": source})
    found = writable.writable(modules.build_symbols(build(root, a=f"{APP}/a.c"), root=root))
    assert found == dict.fromkeys(("common_one", "filled", "zeroed"), f"{APP}/a.c")
    problems = writable.complaints(found, {"zeroed": "why", "filled": "why", "gone": "why"})
    assert problems == [
        f"{APP}/a.c: common_one can be written by every module: make it static",
        "the table's gone is no variable of the firmware",
    ]


def test_a_division_of_signed_values_is_found():
    names = {"__divmodsi4", "__udivmodsi4", "divide", "__divhi3"}
    assert symbols.forbidden_in(names, symbols.ANYWHERE) == [
        "a division of signed values (__divhi3)",
        "a division of signed values (__divmodsi4)",
    ]


def test_a_source_that_is_compiled_twice_is_looked_at_twice(tree):
    root = tree({f"{APP}/kind.c": "int NAME;\n", f"{APP}/other.c": "int f;\n"})
    folder = build(root, kind=f"{APP}/kind.c", again=f"{APP}/kind.c", other=f"{APP}/other.c")
    found = modules.build_symbols(folder, root=root)
    assert [one.source for one in found] == [f"{APP}/kind.c"] * 2 + [f"{APP}/other.c"]


HEADER = """\
// SPDX-License-Identifier: MIT
// Two lines of
// comment.
#pragma once

int f(int a); // and one beside code
/* One
   of two lines. */
int g(void);
"""


def test_comments_and_code_are_counted():
    assert figures.comment_lines(HEADER) == (5, 3)
    assert figures.comment_lines("// This file is MIT; and more.\nint x;\n") == (0, 1)


def measured(root, limits):
    """Return the complaints of the figures about a tree's firmware."""
    files = figures.part_files("firmware", common.repository_files(root), root)
    found = figures.measure("firmware", limits, files)
    return [figure.name.partition(", ")[2] for figure in found if figure.missed]


LIMITS = figures.Limits((3, 3), (4, 4), (5, 5), (1.0, 1.0))


def function(name, lines):
    """Return a function with so many lines of code."""
    return f"int {name}(int a)\n{{\n" + "    a++;\n" * (lines - 3) + "}\n"


@pytest.mark.parametrize(
    ("sizes", "missed"),
    [
        ([3] * 19 + [5], []),
        ([3] * 19 + [6], ["code lines of a function, the longest has"]),
        ([3] * 8 + [5] * 2, ["code lines of a function, nine of ten have"]),
        ([3] * 5 + [4] * 5, ["code lines of a function, half of 10 have"]),
    ],
)
def test_functions_over_a_limit_are_found(tree, sizes, missed):
    text = "".join(function(f"f{index}", lines) for index, lines in enumerate(sizes))
    root = tree({f"{APP}/a.c": text, f"{APP}/a.h": "// One.\nint x(void);\n"})
    assert measured(root, LIMITS) == missed


def test_headers_without_comments_are_found_and_naked_handlers_left_out(tree):
    naked = "ISR(ESTOP_VECTOR, ISR_NAKED)\n{\n" + '    __asm__("nop");\n' * 40 + "}\n"
    text = function("f", 3) + naked
    root = tree({f"{APP}/a.c": text, f"{APP}/a.h": "// One.\nint x(void);\nint y(void);\n"})
    assert measured(root, LIMITS) == ["comment lines for each code line of a header"]


def test_a_figure_names_its_goal():
    row = figures.Figure("lines", 37, 37, 36, where="f in a.c").row()
    assert row == "lines: 37, at most 37, goal 36 (f in a.c)"
    assert figures.Figure("share", 0.5, 0.5, 0.5, at_least=True).row() == "share: 0.5, at least 0.5"


def test_boards_are_the_files_of_the_folder_in_the_order_of_their_numbers(tree):
    place = "firmware/avr/boards"
    root = tree(
        {
            f"{place}/zed.def": "#define BOARD_ID          1\n",
            f"{place}/ant.def": "#define BOARD_ID          12\n",
            f"{place}/bee.def": "#define BOARD_ID          3 // third\n",
            f"{place}/notes.md": "",
        }
    )
    assert common.board_names(root) == ["zed", "bee", "ant"]


def test_the_drawing_has_users_above_what_they_use():
    graph = graph_of("firmware/app/a firmware/core/b", "firmware/core/b firmware/core/c")
    graph.note("firmware/app/a", "firmware/core/c", "c.h")
    graph.note("firmware/core/c", "firmware/app/a", "a()")
    allowed = {("firmware/core/c", "firmware/app/a"): "by name"}
    assert module_graph.text(graph, allowed) == (
        " 2  app/a   core/b\n"
        " 1  core/b  c\n"
        " 0  core/c  -\n"
        "\n"
        "against the levels:\n"
        "    core/c -> app/a: by name\n"
    )
    assert " 2  app/a   core/b core/c\n" in module_graph.text(graph, allowed, every=True)
    assert '"firmware/core/c" -> "firmware/app/a" [color=red];' in module_graph.dot(graph, allowed)


@pytest.mark.parametrize("part", module_graph.TABLES)
def test_a_drawing_that_is_out_of_date_is_found(tmp_path, monkeypatch, part):
    drawn = dict.fromkeys(module_graph.TABLES, "```\nnow\n```\n")
    monkeypatch.setattr(module_graph, "drawings", lambda: drawn)
    text = "".join(module_graph.markdown.marked(name, one) for name, one in drawn.items())
    path = tmp_path / "MODULES.md"
    path.write_text(text)
    monkeypatch.setattr("sys.argv", ["module_graph.py", "--check", str(path)])
    assert module_graph.deliver(module_graph.arguments()) == []
    path.write_text(text.replace(f"{part} -->\n```\nnow", f"{part} -->\n```\nthen"))
    stale = module_graph.deliver(module_graph.arguments())
    assert len(stale) == 1 and f"the drawing {part} is out of date" in stale[0]

# SPDX-License-Identifier: MIT
"""The modules of the C code and who uses whom: the graph behind the rule `circles` and its drawing.

A module is a source (.c, .S) with the header of the same stem; a contract in firmware/hal and the
source in firmware/avr/hal that keeps it are one module too, as are a source or header of core and
its assembly half in firmware/avr/core. A module uses another one if one of its
files includes the other's header, or if its object refers to a symbol that the other's defines.
"""

import functools
import itertools
import json
import re
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import layers
from common import ROOT

SOURCES = {".c", ".S"}
FILES = SOURCES | {".h"}

# Sources here keep the contracts of that folder.
KEEPERS = {"firmware/avr/hal": "firmware/hal"}

# Assembly here is the half of a module there, named by the first file of it in its comment.
HALVES, WHOLES = "firmware/avr/core", "firmware/core"
NAMED = re.compile(r"\b\w+\.[ch]\b")

# nm's letters of what a file defines for others: code, data, weak symbols.
DEFINED = set("TDBCGSRVW")
SYMBOL = re.compile(r"^(?:[0-9a-fA-F]+)?\s*(?P<kind>[A-Za-z]) (?P<name>[A-Za-z_]\w*)$")


class ModuleError(Exception):
    """The graph cannot be made; the message says why."""


@dataclass
class Graph:
    """Who uses whom: for each module the modules that it uses, and by what."""

    uses: dict[str, dict[str, list[str]]] = field(default_factory=dict)

    def add(self, module: str) -> None:
        """A module, with or without neighbours."""
        self.uses.setdefault(module, {})

    def note(self, user: str, used: str, what: str) -> None:
        """One thing of `used` that `user` needs: a header's path or a symbol's name."""
        self.add(user)
        self.add(used)
        if user != used:
            reasons = self.uses[user].setdefault(used, [])
            if what not in reasons:
                reasons.append(what)

    def without(self, edges: Iterable[tuple[str, str]]) -> "Graph":
        """The same graph less some edges."""
        left_out = set(edges)
        kept = {
            user: {used: why for used, why in targets.items() if (user, used) not in left_out}
            for user, targets in self.uses.items()
        }
        return Graph(kept)


@dataclass(frozen=True)
class Symbols:
    """What one object file defines for others and what it wants from others."""

    source: str  # path in the repository
    defined: dict[str, str]  # nm's letter by name
    wanted: frozenset[str]


def module_of(path: str, root: Path = ROOT) -> str:
    """Name of the module that a file belongs to: its path without suffix, the contract's if any."""
    folder, stem = Path(path).parent.as_posix(), Path(path).stem
    if folder == HALVES:
        return whole_of(root / path, root)
    contract = KEEPERS.get(folder)
    if contract and (root / contract / f"{stem}.h").is_file():
        folder = contract
    return f"{folder}/{stem}"


@functools.cache
def whole_of(half: Path, root: Path) -> str:
    """The module of core that an assembly source is the half of; ModuleError if it names none."""
    head = itertools.takewhile(
        lambda line: line.startswith(";"), half.read_text(encoding="utf-8").splitlines()
    )
    for name in NAMED.findall("\n".join(head)):
        for whole in sorted((root / WHOLES).rglob(name)):
            return f"{whole.parent.relative_to(root).as_posix()}/{whole.stem}"
    raise ModuleError(f"{half}: its comment names no file of {WHOLES} whose half it is")


def module_files(files: Iterable[Path], folder: str, root: Path = ROOT) -> list[str]:
    """Paths below a folder that belong to modules, tests left out."""
    paths = (file.relative_to(root).as_posix() for file in files if file.suffix in FILES)
    return sorted(path for path in paths if path.startswith(f"{folder}/") and "/tests/" not in path)


def included(path: str, root: Path = ROOT) -> list[str]:
    """Repository paths of the quoted includes of a file; tables (.def) are nobody's module."""
    found = []
    for line in (root / path).read_text(encoding="utf-8").splitlines():
        match = layers.INCLUDE.match(line)
        if match and match["open"] == '"':
            target = find_header(match["name"], path, root)
            if target and Path(target).suffix == ".h":
                found.append(target)
    return found


def find_header(name: str, includer: str, root: Path) -> str | None:
    """Repository path of a quoted include, looked for as the compiler does."""
    starts = [(root / includer).parent, *(root / start for start in layers.SEARCHED)]
    for folder in starts:
        candidate = (folder / name).resolve()
        if candidate.is_file() and candidate.is_relative_to(root.resolve()):
            return candidate.relative_to(root.resolve()).as_posix()
    return None


def include_graph(paths: Iterable[str], root: Path = ROOT) -> Graph:
    """The graph of includes among the given files."""
    graph, known = Graph(), list(paths)
    inside = {module_of(path, root) for path in known}
    for path in known:
        graph.add(module_of(path, root))
        for target in included(path, root):
            if module_of(target, root) in inside:
                graph.note(module_of(path, root), module_of(target, root), target)
    return graph


def objects(build: Path, folder: str = "firmware", root: Path = ROOT) -> list[tuple[str, Path]]:
    """Sources of a folder, each with an object file that the folder's own part of a build makes.

    A source that is compiled several times has as many.
    """
    listing = build / "compile_commands.json"
    try:
        commands = json.loads(listing.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ModuleError(f"{listing}: {error}: configure and build first") from None
    found = []
    for command in commands:
        file, made = Path(command["file"]), object_of(command)
        ours = made.startswith(f"{folder}/") and file.is_relative_to(root / folder)
        if ours and "/tests/" not in made:
            source = file.relative_to(root).as_posix()
            found.append((source, Path(command["directory"]) / made))
    if not found:
        raise ModuleError(f"{listing}: nothing of {folder} in it")
    return sorted(found)


def object_of(command: dict[str, str]) -> str:
    """The object file that one compile command makes, as it is written there."""
    # No object's name is quoted, and shlex would take most of the rules' time.
    words = command["command"].split()
    return words[words.index("-o") + 1]


def read_symbols(made: list[tuple[str, Path]], nm: str) -> list[Symbols]:
    """Let nm list object files, all in one run."""
    paths = [str(path) for _, path in made]
    try:
        listed = subprocess.run([nm, "-gA", *paths], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        words = getattr(error, "stderr", "") or str(error)
        raise ModuleError(f"{words.strip()}: build first") from None
    rows: dict[str, list[str]] = {path: [] for path in paths}
    for row in listed.stdout.splitlines():
        path, _, symbol = row.rpartition(":")
        rows[path].append(symbol)
    return [parse_symbols(source, "\n".join(rows[str(path)])) for source, path in made]


def parse_symbols(source: str, listing: str) -> Symbols:
    """Read the output of nm -g."""
    rows = [match for match in map(SYMBOL.match, map(str.strip, listing.splitlines())) if match]
    defined = {row["name"]: row["kind"] for row in rows if row["kind"] in DEFINED}
    wanted = frozenset(row["name"] for row in rows if row["kind"] in "Uw")
    return Symbols(source, defined, wanted)


def build_symbols(build: Path, folder: str = "firmware", root: Path = ROOT) -> list[Symbols]:
    """The symbols of every object of a build, read by the nm that its compiler came with."""
    made = objects(build, folder, root)
    cache = (build / "CMakeCache.txt").read_text(encoding="utf-8")
    chosen = re.search(r"^CMAKE_NM:\w+=(.+)$", cache, re.MULTILINE)
    nm = chosen[1] if chosen else "nm"
    return read_symbols(made, nm)


def declares(header: str, name: str, root: Path = ROOT) -> bool:
    """Whether a header declares a function of that name."""
    return name in declared(root / header)


@functools.cache
def declared(header: Path) -> frozenset[str]:
    """The names before a parenthesis in a header."""
    return frozenset(re.findall(r"\b(\w+)\s*\(", header.read_text(encoding="utf-8")))


def port_of(name: str, ports: Iterable[str], root: Path = ROOT) -> str | None:
    """The port header that declares a symbol: who calls it uses the port, not who stands behind."""
    return next((port for port in ports if declares(port, name, root)), None)


def note_symbols(
    graph: Graph, found: list[Symbols], ports: Iterable[str] = (), root: Path = ROOT
) -> None:
    """Add the edges that the symbols of one build's objects make."""
    owners = {name: one.source for one in found for name in one.defined}
    for one in found:
        for name in sorted(one.wanted & owners.keys()):
            used = port_of(name, ports, root) or owners[name]
            graph.note(module_of(one.source, root), module_of(used, root), f"{name}()")


def knots(graph: Graph) -> list[list[str]]:
    """The sets of modules that reach each other, those of one module left out (Tarjan)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    trail: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        trail.append(node)
        for target in sorted(graph.uses[node]):
            if target not in index:
                visit(target)
            if target in trail:
                low[node] = min(low[node], low[target])
        if low[node] == index[node]:
            start = trail.index(node)
            if len(trail) - start > 1:
                found.append(sorted(trail[start:]))
            del trail[start:]

    for node in sorted(graph.uses):
        if node not in index:
            visit(node)
    return sorted(found)


def shortest_way(graph: Graph, start: str, end: str) -> list[str] | None:
    """A shortest way from one module to another along what they use."""
    came_from: dict[str, str] = {}
    waiting = [start]
    for node in waiting:
        for target in sorted(graph.uses.get(node, {})):
            if target in came_from or target == start:
                continue
            came_from[target] = node
            if target == end:
                way = [end]
                while way[-1] != start:
                    way.append(came_from[way[-1]])
                return way[::-1]
            waiting.append(target)
    return None


def circles(graph: Graph) -> list[list[str]]:
    """Circles that together hold every edge inside a knot, each a shortest one, named once."""
    found: dict[tuple[str, ...], list[str]] = {}
    for knot in knots(graph):
        for user in knot:
            for used in sorted(set(graph.uses[user]) & set(knot)):
                way = shortest_way(graph, used, user) or []
                first = way.index(min(way))
                circle = way[first:] + way[:first]
                found.setdefault(tuple(circle), circle)
    return [found[key] for key in sorted(found)]


def short(module: str) -> str:
    """A module's name for people: the firmware's without its folder."""
    return module.removeprefix("firmware/")

# SPDX-License-Identifier: MIT
"""What a walked document holds: commands with their outputs, commands that are not run, pictures.

Fenced blocks are of these kinds, by the words behind their backquotes:

    console       commands ("$ ", continued behind a backslash) with their output: all are run
    console bench one command that goes on in a window of its own: a virtual bench
    console long  as console, by the long check alone
    console WHY   the same, not run because it needs WHY: one of NOT_RUN
    sh WHY        commands only, not run
    toml FILE     a file that the reader writes (text FILE as well)
    text          something to look at, without commands; also toml, python, json and the like

In an output stands also what is typed while the command runs: the answer behind a question
("[Y/n]: y"), and behind "bench> " a command in the window of the bench. Each is typed when all
that stands before it has been printed; what comes before a command, or first behind it, before its
start.

Outputs agree by *the rule of the dots*: in the document a line `...` stands for any lines (or
none), `...` inside a line for any characters of it; all else is literally what the command prints,
but for blanks at line ends and tabs, which are written as blanks.

A picture is an image whose title names the file of the walk that it shows:
![words](pictures/speed.png "run/motion.png").
"""

import re
import shlex
from dataclasses import dataclass, replace

DOTS = "..."
NOT_RUN = {
    "network": "other computers, or an index of packages",
    "root": "the rights of root",
    "board": "a board on a port",
    "build": "a clone and its build, which the checks make and run themselves",
    "hours": "minutes to hours",
    "terminal": "somebody at a terminal, or at a browser",
}
LOOKED_AT = ("text", "toml", "python", "py", "json", "ini")
_FENCE = "```"
_PROMPT = "$ "
BENCH = "bench> "
_QUESTION = re.compile(r"(?P<question>.*\[[Yy]/[Nn]\]: )(?P<answer>\w+)")
_END_OF_FILE = "END"
_IMAGE = re.compile(r'!\[[^\]]*\]\((?P<shown>[^)\s]+)(?: "(?P<made>[^"]+)")?\)')


@dataclass(frozen=True)
class TutorialStep:
    """A command and the output that the document shows; `line` is where it stands, from 1."""

    line: int
    command: str
    shown: tuple[str, ...]
    before: tuple[str, ...] = ()  # typed at the bench
    window: bool = False  # goes on beside the others, in a window of its own
    long: bool = False  # run by the long check alone

    @property
    def typed_to(self) -> bool:
        """True if something is typed before the command or while it runs."""
        return self.window or bool(self.before or cues(self))


@dataclass(frozen=True)
class Cue:
    """What is typed while a command runs, and the pattern of what it has printed by then."""

    after: str
    text: str
    bench: bool


@dataclass(frozen=True)
class NotRun:
    """A command that needs what a test has not."""

    line: int
    command: str
    needs: str


@dataclass(frozen=True)
class Picture:
    """A picture: where the document has it, and the file of the walk that it is."""

    line: int
    shown: str
    made: str


@dataclass(frozen=True)
class Document:
    """All that a document says; `complaints` are places that say nothing clear."""

    text: tuple[str, ...]
    steps: tuple[TutorialStep, ...]
    not_run: tuple[NotRun, ...]
    pictures: tuple[Picture, ...]
    complaints: tuple[str, ...]

    def with_outputs(self, fresh: dict[int, list[str]]) -> str:
        """Return the text with the outputs of some steps, by their line, replaced."""
        lines = list(self.text)
        for step in sorted(self.steps, key=lambda item: -item.line):
            if step.line in fresh:
                begin = step.line - 1 + len(step.command.split("\n"))
                lines[begin : begin + len(step.shown)] = fresh[step.line]
        return "\n".join(lines) + "\n"


def parse(text: str) -> Document:
    """Read a document."""
    lines = tuple(text.rstrip("\n").split("\n"))
    steps: list[TutorialStep] = []
    not_run: list[NotRun] = []
    pictures: list[Picture] = []
    complaints: list[str] = []
    for first, kind, body in _parts(lines):
        words = kind.split()
        if kind in ("console", "console bench", "console long"):
            made = _steps(first, body, complaints)
            steps += [replace(one, window="bench" in kind, long="long" in kind) for one in made]
        elif len(words) == 2 and words[0] in ("console", "sh") and words[1] in NOT_RUN:
            found = (
                _commands(first, body) if words[0] == "sh"
                else [NotRun(one.line, one.command, "") for one in _steps(first, body, complaints)]
            )  # fmt: skip
            not_run += [replace(item, needs=words[1]) for item in found]
        elif words[:1] in (["toml"], ["text"]) and len(words) == 2:
            steps.append(_file(first, words[1], body))
        elif kind == _FENCE:
            pictures += _pictures(first, body, complaints)
        elif kind not in LOOKED_AT:
            complaints.append(f"{first - 1}: a block of unknown kind {kind!r}")
        elif kind == "text" and any(line.startswith(_PROMPT) for line in body):
            complaints.append(f"{first - 1}: commands in a block of text")
    return Document(lines, tuple(steps), tuple(not_run), tuple(pictures), tuple(complaints))


def agrees(shown: tuple[str, ...] | list[str], printed: list[str]) -> bool:
    """True if an output is what the document shows, by the rule of the dots."""
    pattern = "".join(
        r"(?:[^\n]*\n)*?" if line.strip() == DOTS else _pattern(line) + "\n"
        for line in plain(shown)
    )
    return re.fullmatch(pattern, "".join(f"{line}\n" for line in plain(printed))) is not None


def cues(step: TutorialStep) -> list[Cue]:
    """Return what is typed while a command runs, in its order."""
    found: list[Cue] = []
    after = ""
    for line in step.shown:
        question = _QUESTION.fullmatch(line)
        if line.startswith(BENCH):
            found.append(Cue(after, line.removeprefix(BENCH), bench=True))
        elif question:
            found.append(Cue(f"^{_pattern(question['question'])}", question["answer"], bench=False))
        if line.startswith(BENCH) or question:
            after = ""
        elif line.strip() != DOTS:
            after = f"^{_pattern(line.rstrip())} *\n"
    return found


def _pattern(line: str) -> str:
    return "[^\n]*".join(map(re.escape, line.split(DOTS)))


def plain(lines: tuple[str, ...] | list[str]) -> list[str]:
    """Return lines without tabs and without blanks at their ends, nor empty ones at the end."""
    found = [line.expandtabs().rstrip() for line in lines]
    while found and not found[-1]:
        found.pop()
    return found


def _parts(lines: tuple[str, ...]) -> list[tuple[int, str, list[str]]]:
    """Split into parts: number of the first line, kind of the block (_FENCE outside), lines."""
    parts: list[tuple[int, str, list[str]]] = [(1, _FENCE, [])]
    inside = False
    for number, line in enumerate(lines, start=1):
        if line.startswith(_FENCE):
            inside = not inside
            parts.append((number + 1, line.removeprefix(_FENCE).strip() if inside else _FENCE, []))
        else:
            parts[-1][2].append(line)
    return parts


def _steps(first: int, body: list[str], complaints: list[str]) -> list[TutorialStep]:
    """Return the commands of a console block."""
    steps: list[TutorialStep] = []
    before: list[str] = []
    continued = False
    for number, line in enumerate(body, start=first):
        if continued:
            steps[-1] = replace(steps[-1], command=f"{steps[-1].command}\n{line}")
        elif line.startswith(_PROMPT):
            if steps:
                steps[-1], before = _without_bench(steps[-1])
            steps.append(TutorialStep(number, line.removeprefix(_PROMPT), (), tuple(before)))
        elif steps:
            steps[-1] = replace(steps[-1], shown=(*steps[-1].shown, line))
        elif line.startswith(BENCH):
            before.append(line.removeprefix(BENCH))
        else:
            complaints.append(f"{number}: output without a command")
        continued = (continued or line.startswith(_PROMPT)) and line.endswith("\\")
    if body[-1:] and body[-1].startswith(BENCH):
        complaints.append(f"{first + len(body) - 1}: typed at the bench behind the last output")
    return steps


def _without_bench(step: TutorialStep) -> tuple[TutorialStep, list[str]]:
    """Return a step without what is typed at the bench behind its output, and that."""
    shown = list(step.shown)
    before: list[str] = []
    while shown and shown[-1].startswith(BENCH):
        before.insert(0, shown.pop().removeprefix(BENCH))
    return replace(step, shown=tuple(shown)), before


def _file(first: int, name: str, body: list[str]) -> TutorialStep:
    """Return the step that writes a file as a reader would with an editor."""
    text = "\n".join([f"cat >{shlex.quote(name)} <<'{_END_OF_FILE}'", *body, _END_OF_FILE])
    return TutorialStep(first - 1, text, ())


def _commands(first: int, body: list[str]) -> list[NotRun]:
    found: list[NotRun] = []
    begun = ""
    for number, line in enumerate(body, start=first):
        command = begun + line.split("  #")[0].strip()
        begun = command.removesuffix("\\") if command.endswith("\\") else ""
        if command and not begun and not command.startswith("#"):
            found.append(NotRun(number, command, ""))
    return found


def _pictures(first: int, body: list[str], complaints: list[str]) -> list[Picture]:
    found = []
    for number, line in enumerate(body, start=first):
        for image in _IMAGE.finditer(line):
            if image["made"]:
                found.append(Picture(number, image["shown"], image["made"]))
            else:
                complaints.append(f"{number}: {image['shown']}: no title says what makes it")
    return found

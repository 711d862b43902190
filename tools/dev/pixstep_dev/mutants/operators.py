# SPDX-License-Identifier: MIT
"""Which small changes a C source offers: one operator, one constant, one statement.

The text is taken apart into tokens, so comments, strings and directives are left alone; of a macro
the replacement is code like any other.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

_TOKEN = re.compile(
    r"(?P<space>(?:\s|\\\n|//[^\n]*|/\*.*?\*/)+)"
    r"|(?P<text>\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])*')"
    r"|(?P<number>(?:0[xX][0-9a-fA-F]+|\d+)[uUlL]*)"
    r"|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<sign><<=|>>=|->|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|.)",
    re.DOTALL,
)
_DIRECTIVE = re.compile(
    r"^[ \t]*#[ \t]*(?:(?P<head>define[ \t]+\w+(?:\([^)]*\))?)(?P<body>(?:\\\n|[^\n])*)"
    r"|(?:\\\n|[^\n])*)",
    re.MULTILINE,
)
_FUNCTION = re.compile(r"^[A-Za-z_][^;{}()#=]*?\b(\w+)\([^;{}]*\)\n\{", re.MULTILINE)
_NUMBER = re.compile(r"(0[xX])?([0-9a-fA-F]+?)([uUlL]*)")

# What becomes of a binary sign, by kind of change.
_SIGNS = {
    "<": ("relation", "<=", ">="),
    "<=": ("relation", "<", ">"),
    ">": ("relation", ">=", "<="),
    ">=": ("relation", ">", "<"),
    "==": ("relation", "!="),
    "!=": ("relation", "=="),
    "+": ("arithmetic", "-"),
    "-": ("arithmetic", "+"),
    "+=": ("arithmetic", "-="),
    "-=": ("arithmetic", "+="),
    "&&": ("logic", "||"),
    "||": ("logic", "&&"),
    "&": ("bits", "|"),
    "|": ("bits", "&"),
    "^": ("bits", "&"),
    "<<": ("bits", ">>"),
    ">>": ("bits", "<<"),
    "&=": ("bits", "|="),
    "|=": ("bits", "&="),
    "^=": ("bits", "&="),
    "<<=": ("bits", ">>="),
    ">>=": ("bits", "<<="),
}
_STEPS = {"++": "--", "--": "++"}
_CONTROL = ("if", "for", "while", "switch")
_TYPES = frozenset(
    (
        "bool",
        "char",
        "const",
        "enum",
        "int",
        "long",
        "short",
        "signed",
        "struct",
        "unsigned",
        "void",
    )
)
_KEYWORDS = frozenset(
    (
        *("break", "case", "continue", "default", "do", "else", "for", "goto", "if", "return"),
        *("sizeof", "switch", "while", "auto", "const", "enum", "extern", "inline", "register"),
        *("static", "struct", "typedef", "union", "volatile", "_Static_assert"),
    )
)
_GOES_ON = frozenset(("=", "(", ".", "->", "[", "++", "--", *(s for s in _SIGNS if s[-1] == "=")))
_GOES_ON -= {"<=", ">=", "==", "!="}
_OPENING = {"(": ")", "[": "]", "{": "}"}

KINDS = (
    *("relation", "arithmetic", "constant", "logic", "bits", "statement", "return"),
    "register",  # of assembly
)


@dataclass(frozen=True)
class Mutant:
    """In `file`, at character `start`, `right` becomes `wrong`."""

    file: str
    line: int
    kind: str
    start: int
    right: str
    wrong: str
    inside: str  # which function; "" outside of all
    was: str  # the lines concerned, as one, and those before as long as they are not the only such
    becomes: str

    def apply(self, text: str) -> str:
        """Return the changed text of the file; raises ValueError if it is another text by now."""
        end = self.start + len(self.right)
        if text[self.start : end] != self.right:
            raise ValueError(f"{self.file}:{self.line}: is no longer {self.right!r}")
        return text[: self.start] + self.wrong + text[end:]


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    start: int

    @property
    def end(self) -> int:
        return self.start + len(self.text)


def mutants(file: str, text: str) -> list[Mutant]:
    """Return every change that a source offers, in the order of the text."""
    found = [
        _mutant(file, text, *change)
        for part, start, in_macro in _parts(text)
        for change in _CodePart(part, start, in_macro).changes()
    ]
    return sorted(found, key=lambda mutant: (mutant.start, mutant.kind, mutant.wrong))


def _mutant(file: str, text: str, kind: str, start: int, end: int, wrong: str) -> Mutant:
    """Make a mutant; a longer one keeps its line ends, so nothing moves to another line."""
    right = text[start:end]
    wrong += "\n" * (right.count("\n") - wrong.count("\n"))
    first = text.rfind("\n", 0, start) + 1
    last = text.find("\n", end)
    last = len(text) if last < 0 else last
    while first > 0 and text.count(text[first - 1 : last]) > 1:  # the line before tells which
        first = text.rfind("\n", 0, first - 1) + 1
    was = _as_one_line(text[first:last])
    becomes = _as_one_line(text[first:start] + wrong + text[end:last])
    line = text.count("\n", 0, start) + 1
    return Mutant(file, line, kind, start, right, wrong, _inside(text, start), was, becomes)


def _inside(text: str, start: int) -> str:
    """Return the name of the function around a place."""
    for found in _FUNCTION.finditer(text):
        if found.start() <= start <= text.find("\n}", found.end()):
            return found[1]
    return ""


def _as_one_line(text: str) -> str:
    return " ".join(re.sub(r"//[^\n]*|\\\n", "", text).split())


def _parts(text: str) -> Iterator[tuple[str, int, bool]]:
    """Yield the code with every directive blanked, then each macro's replacement."""
    code = _DIRECTIVE.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
    yield code, 0, False
    for found in _DIRECTIVE.finditer(text):
        if found["head"]:
            yield found["body"], found.start("body"), True


class _CodePart:
    """A piece of code as tokens."""

    def __init__(self, text: str, start: int, in_macro: bool) -> None:
        every = [
            _Token(str(found.lastgroup), found[0], start + found.start())
            for found in _TOKEN.finditer(text)
        ]
        self.text, self.start, self.in_macro = text, start, in_macro
        self.tokens = [token for token in every if token.kind != "space"]
        self.partner = self._partners()
        self.asserted = self._asserted()

    def _partners(self) -> dict[int, int]:
        """Return the place of each bracket's partner."""
        waiting: list[int] = []
        partner: dict[int, int] = {}
        for at, token in enumerate(self.tokens):
            if token.text in _OPENING:
                waiting.append(at)
            elif token.text in _OPENING.values() and waiting:
                partner[at] = waiting.pop()
                partner[partner[at]] = at
        return partner

    def _asserted(self) -> set[int]:
        """Return the tokens that only the compiler looks at."""
        inside: set[int] = set()
        for at, token in enumerate(self.tokens):
            if token.text in ("_Static_assert", "__attribute__") and at + 1 in self.partner:
                inside.update(range(at, self.partner[at + 1] + 1))
        return inside

    def changes(self) -> Iterator[tuple[str, int, int, str]]:
        """Yield kind, start, end and what is put there."""
        for at, token in enumerate(self.tokens):
            if at in self.asserted:
                continue
            for kind, wrong in self._of_token(at, token):
                yield kind, token.start, token.end, wrong
            if not self.in_macro:
                yield from self._of_condition(at)
        if not self.in_macro:
            for first, last in self._bodies():
                boolean = self._is_boolean(first)
                for at in self._outside_parentheses(first + 1, last):
                    yield from self._of_statement(at, last)
                    yield from self._of_return(at, boolean)

    def _outside_parentheses(self, first: int, last: int) -> Iterator[int]:
        at = first
        while at < last:
            yield at
            at = self.partner.get(at, at) if self.tokens[at].text in ("(", "[") else at
            at += 1

    def _of_token(self, at: int, token: _Token) -> Iterator[tuple[str, str]]:
        if token.kind == "number":
            yield from (("constant", wrong) for wrong in _neighbours(token.text))
        elif token.text in _STEPS:
            yield "arithmetic", _STEPS[token.text]
        elif token.text == "!":
            yield "logic", ""
        elif token.text == "~":
            yield "bits", ""
        elif token.text in _SIGNS and self._binary(at):
            kind, *wrongs = _SIGNS[token.text]
            yield from ((kind, wrong) for wrong in wrongs)

    def _binary(self, at: int) -> bool:
        """Whether a sign has an operand on its left: `(uint8_t)-1` and `return -1` have none."""
        if at == 0:
            return False
        before = self.tokens[at - 1]
        if before.text == ")":
            return not self._is_cast(at - 1)
        return before.text == "]" or (
            before.kind in ("name", "number") and before.text not in _KEYWORDS
        )

    def _is_cast(self, closing: int) -> bool:
        opening = self.partner.get(closing, closing)
        inside = self.tokens[opening + 1 : closing]
        if opening > 0 and self.tokens[opening - 1].kind == "name":
            return self.tokens[opening - 1].text in ("return", "case")
        return bool(inside) and all(
            token.text in _TYPES or token.text == "*" or token.text.endswith("_t")
            or (token.kind == "name" and inside[0].text in ("struct", "enum"))
            for token in inside
        )  # fmt: skip

    def _of_condition(self, at: int) -> Iterator[tuple[str, int, int, str]]:
        """Yield the negation of an if's or a while's condition."""
        if self.tokens[at].text not in ("if", "while") or at + 1 not in self.partner:
            return
        opening, closing = self.tokens[at + 1], self.tokens[self.partner[at + 1]]
        inside = self._cut(opening.end, closing.start)
        if inside.strip() != "0":
            yield "logic", opening.end, closing.start, f"!({inside})"

    def _cut(self, start: int, end: int) -> str:
        return self.text[start - self.start : end - self.start]

    def _bodies(self) -> Iterator[tuple[int, int]]:
        """Yield the braces of each function."""
        at = 0
        while at < len(self.tokens):
            if self.tokens[at].text in _OPENING and at in self.partner:
                if self.tokens[at].text == "{" and at and self.tokens[at - 1].text == ")":
                    yield at, self.partner[at]
                at = self.partner[at]
            at += 1

    def _is_boolean(self, first: int) -> bool:
        """Whether the function whose body begins here returns a bool."""
        at = self.partner.get(first - 1, first)
        while at and self.tokens[at - 1].text not in (";", "}"):
            at -= 1
            if self.tokens[at].text == "bool":
                return True
        return False

    def _of_statement(self, at: int, last: int) -> Iterator[tuple[str, int, int, str]]:
        """Yield the statement that begins here with nothing in its place."""
        token = self.tokens[at]
        if not self._begins(at):
            return
        if token.text in ("break", "continue") or (
            token.text == "return" and self.tokens[at + 1].text == ";"
        ):
            end = at + 1
        else:
            end = self._end(at, last)
        if end:
            yield "statement", token.start, self.tokens[end].end, ";"

    def _begins(self, at: int) -> bool:
        before = self.tokens[at - 1].text
        if before == ")":
            opening = self.partner.get(at - 1, 0)
            return opening > 0 and self.tokens[opening - 1].text in _CONTROL
        return before in (";", "{", "}", "else") or (before == ":" and self._is_label(at - 1))

    def _is_label(self, colon: int) -> bool:
        """Whether a colon ends `case ...` or `default`."""
        at = colon
        while at and self.tokens[at - 1].text not in (";", "{", "}", "?", ":"):
            at -= 1
        return self.tokens[at].text in ("case", "default")

    def _end(self, at: int, last: int) -> int:
        """Return where the assignment or call that begins here ends; 0: it is neither."""
        token, behind = self.tokens[at], self.tokens[at + 1]
        if token.kind == "name":
            if token.text in _KEYWORDS | _TYPES or behind.text not in _GOES_ON:
                return 0
        elif token.text not in ("*", "(", "++", "--"):
            return 0
        while at < last and self.tokens[at].text != ";":
            if self.tokens[at].text in ("}", ")", "]"):
                return 0
            at = self.partner.get(at, at) + 1 if self.tokens[at].text in _OPENING else at + 1
        return at if at < last else 0

    def _of_return(self, at: int, boolean: bool) -> Iterator[tuple[str, int, int, str]]:
        """Yield another value for a return statement."""
        if self.tokens[at].text != "return" or self.tokens[at + 1].text == ";":
            return
        end = at + 1
        while self.tokens[end].text != ";":
            end = self.partner.get(end, end) + 1
        start, stop = self.tokens[at + 1].start, self.tokens[end].start
        value = self._cut(start, stop)
        opposite = {"true": "false", "false": "true"}
        if value in opposite:
            yield "return", start, stop, opposite[value]
        elif boolean:
            yield "return", start, stop, f"!({value})"
        else:
            yield "return", start, stop, "1" if value in ("0", "0u") else "0"


def _neighbours(number: str) -> Iterator[str]:
    """Yield a constant's neighbours, written as it is; below 0 there is none."""
    found = _NUMBER.fullmatch(number)
    if not found:
        return
    prefix, digits, suffix = found[1] or "", found[2], found[3]
    value = int(digits, 16 if prefix else 10)
    for other in (value + 1, value - 1):
        if other >= 0:
            yield f"{prefix}{other:X}{suffix}" if prefix else f"{other}{suffix}"

# SPDX-License-Identifier: MIT
"""What operations say to a Python program names fields: no text has an option of the command line.

All operations are walked: each field gets wrong values, each file wrong content.
"""

import re
import shlex

import click
import pytest
from click.core import ParameterSource

import test_wrong_values as wrong
from pixstep import ops
from pixstep.cli.examples import EXAMPLES
from pixstep.errors import PlainError, UserError
from pixstep.operations import catalog, python
from pixstep.operations.kinds import InFile, OutFile
from pixstep.operations.request import fields
from test_wrong_values import bus, folder  # noqa: F401  # fixtures

# A command that is quoted as a whole, as `pixstep board scan --bauds`, is one to type.
COMMAND = re.compile(r"`[^`]*`|pixstep( [a-z-]+)+( --[a-z-]+( [^ ]+)?)*( \.\.\.)?")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
CONTENTS = {
    "numbers.csv": "7\n5\n1\n2\n3\n4\n5\n",  # a first line that is not line 1
    "short.csv": "1\n9\n250\n500\n250\n",
    "unix.csv": "0\n250\n500\n250\n",
    "commas.csv": "0,5\n1,25\n2,125\n",
    "arc.pmc": "TS0 TA5 TM90 CIRCLE2 X100 R5\n",  # the radius is too short
    "garbage.csv": "\x00\x01 these are no numbers\n",
    "empty.csv": "",
    "motors.toml": wrong.MACHINE.replace('line.motor = "X"\n', ""),
    "broken.toml": wrong.MACHINE.replace("mega", "mgea"),
}
# With files that will do these go on for ever, or simulate for long.
ENDLESS = (
    "serve", "ioc", "board watch", "board simulate", "watch", "sim", "demo", "home sim", "move sim",
    "trajectory sim", "job simulate", "job run", "job resume",
)  # fmt: skip


@pytest.fixture(scope="module")
def contents(tmp_path_factory):
    """Return files with wrong content."""
    made = tmp_path_factory.mktemp("contents")
    for name, text in CONTENTS.items():
        ends = "\n" if name == "unix.csv" else "\r\n"
        (made / name).write_text(text, newline=ends)
    whole = made / "whole.csv"
    ops.line_make(max_acceleration=100, speed=300, pixels=9, pixel_hz=30, lines=2, name="TWO",
                  output=whole)  # fmt: skip
    rows = whole.read_bytes().splitlines(keepends=True)
    (made / "truncated.csv").write_bytes(b"".join(rows[:-3]))
    (made / "second.csv").write_bytes(b"".join([*rows[:-11], b"7\r\n", *rows[-10:]]))
    return sorted(made.iterdir())


def example(words):
    """Return what the example of an operation gives, by its fields."""
    command = wrong.COMMANDS[words]
    context = click.Context(command)
    line = shlex.split(EXAMPLES[words][0])[len(words.split()) :]
    click.Command.parse_args(command, context, line)
    return {
        name: context.params[name]
        for name in fields(command.request)
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    }


def calls(words, contents):
    """Yield what an operation is called with: an example with one wrong value, or wrong content."""
    request = catalog.load(words)
    given = example(words)
    params = {param.name: param for param in wrong.COMMANDS[words].params}
    for name, one in fields(request).items():
        if not getattr(params[name], "is_flag", False) and (
            (words, wrong.typed(params[name])) not in wrong.GOES_ON
        ):
            for value in wrong.wrong_values(words, params[name]):
                yield given | {name: [value] if one.many else value}
        if isinstance(one.kind, InFile) and not isinstance(one.kind, OutFile):
            for path in contents if words not in ENDLESS else ():
                yield given | {name: [path] if one.many else path}
    yield {}
    yield given | {"nonsense": 1}
    yield given | {"machine": "nowhere.toml"}
    if words not in ENDLESS:
        yield from (given | {"machine": path} for path in contents if path.suffix == ".toml")


def texts(words, given):
    """Return what an operation says when it is called so."""
    try:
        done = getattr(ops, python.name_of(words))(**given)
    except (PlainError, OSError) as error:
        return [str(error)]
    return [*done.notes, done.page()]


@pytest.mark.usefixtures("bus", "simulator", "plan_program")
@pytest.mark.parametrize("words", catalog.OPERATIONS)
def test_no_text_names_an_option(words, contents):
    found = set()
    for given in calls(words, contents):
        for text in texts(words, given):
            if OPTION.search(COMMAND.sub("", text)):
                found.add(text)
    assert not found, "\n".join(sorted(found))


def test_a_field_that_is_wrong_is_named():
    with pytest.raises(UserError, match=r"^divider: "):
        ops.line_make(prn="x.prn", speed=100, divider="abc", output="x.csv")

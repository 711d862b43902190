# SPDX-License-Identifier: MIT
"""Each operation is one thing on the command line and in Python: fields, defaults, results."""

import inspect
import json
import pickle

import click
import jsonschema
import pytest

from command_tree import own_commands
from pixstep import natives, ops
from pixstep.cli.from_operation import OperationCommand, command_of
from pixstep.errors import UserError
from pixstep.operations import catalog, perform, python
from pixstep.operations.asked import AskedError, FieldError, MissingError
from pixstep.operations.kinds import Choice, Flag, Kind, Time
from pixstep.operations.request import fields

COMMANDS = own_commands()
BESIDE = {"machine", "motor", "force", "link", "progress"}
WORDS = sorted(catalog.OPERATIONS)
every = pytest.mark.parametrize("words", WORDS)


@every
def test_command_and_function_have_the_same_fields(words):
    request = catalog.load(words)
    known = fields(request)
    command = COMMANDS[words]
    assert isinstance(command, OperationCommand) and command is command_of(request)
    typed = {param.name: param for param in command.params}
    added = {"as_json", "force", "motor", "machine"} - set(known)
    assert set(known) == set(typed) - added
    called = inspect.signature(getattr(ops, python.name_of(words))).parameters
    assert set(called) - (BESIDE - set(known)) == set(known)
    for name, field in known.items():
        assert called[name].default in (field.default, inspect.Parameter.empty), name
        assert field.option in typed[name].opts or field.argument, name
        assert called[name].annotation == field.python


@every
def test_every_field_says_what_it_is_in_help(words):
    """The unit or the choices, the range, and the default or that it is needed."""
    command = COMMANDS[words]
    ctx = click.Context(command, info_name=words)
    for name, field in fields(catalog.load(words)).items():
        param = next(param for param in command.params if param.name == name)
        assert field.about or field.argument or field.hidden, name
        if field.argument or field.hidden or isinstance(field.kind, Flag):
            continue
        spelled, told = param.get_help_record(ctx)
        named = field.shown or field.kind.name.upper() in spelled.upper()
        assert named or isinstance(field.kind, Choice), name
        text = f"{spelled} {told}"
        if field.required:
            assert "[required]" in text or "required]" in text, name
        elif field.default_text:
            assert f"default: {field.default_text}" in text, name
        elif field.default not in (None, ()):
            assert "default:" in text, name
        if getattr(field.kind, "least", None) is not None and type(field.kind).__name__ == "Whole":
            assert str(field.kind.least) in text, name


@every
def test_first_sentences_are_those_of_the_catalog(words):
    about = inspect.getdoc(catalog.load(words)).split("\n\n")[0]
    assert " ".join(about.split()) == catalog.OPERATIONS[words][1]


@every
def test_results_have_a_schema(words):
    found = catalog.schema(words)
    jsonschema.Draft202012Validator.check_schema(found)
    assert "$ref" in found, f"{words}: say the type of its result"


def test_published_schemas_are_those_of_the_operations():
    published = natives.root() / "docs" / "schemas.json"
    text = json.dumps(catalog.all_schemas(), indent=1, sort_keys=True) + "\n"
    assert published.read_text() == text, "`pixstep-dev docs schemas` prints it"


def test_every_command_is_an_operation():
    """What is left out talks to a shell; some operations have two names."""
    made = {words for words, command in COMMANDS.items() if isinstance(command, OperationCommand)}
    assert set(COMMANDS) - made == {"completion"}
    assert {COMMANDS[words].request.words for words in made} == set(WORDS)


# Values


LINE = {"speed": 1000, "max_acceleration": 100, "pixels": 60, "pixel_hz": 30}


def test_a_function_gives_what_the_command_prints(tmp_path, pixstep):
    made = ops.line_make(**LINE, output=tmp_path / "a.csv")
    printed = json.loads(pixstep(
        "line", "make", "--speed", 1000, "--max-acceleration", 100, "--pixels", 60, "--pixel-hz",
        30, "-o", "b.csv", "--json",
    ))  # fmt: skip
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    del printed["schema"], printed["machine"]
    assert made.to_dict() | {"file": "b.csv"} == printed and made.fine
    assert "60 pixels, 10 accelerating" in made.page() and "60 pixels" in repr(made)


@pytest.mark.parametrize(
    ("given", "kind", "said"),
    [
        ({"speed": "7mm/s"}, FieldError, "speed: speed 7mm/s: needs a motor's steps per mm"),
        ({"speed": -1}, FieldError, "speed: -1: expected a number"),
        ({"pixels": 2.5}, FieldError, "pixels: 2.5: expected a whole number"),
        ({"pixels": True}, FieldError, "pixels: True: expected a whole number"),
        ({"lenient": 1}, FieldError, "lenient: 1: expected True or False"),
        ({"decode": "round"}, FieldError, "decode: 'round' is not one of 'smooth', 'plain'"),
        ({"divider": 0}, FieldError, "divider: 0 is not in the range 1<=x<=1000"),
        ({"pixel_hz": "0"}, FieldError, "pixel_hz: pixel frequency '0': must be above 0 Hz"),
        ({"length": 5}, UserError, "pixels and length: a line has one of them"),
        ({"spee": 1}, UserError, "spee: line_make takes divider, prn"),
        ({"machine": "nowhere.toml"}, UserError, "nowhere.toml"),
        ({"motor": "M39"}, UserError, "M39: no machine file"),
    ],
)
def test_what_is_wrong_names_the_field(tmp_path, given, kind, said):
    with pytest.raises(kind, match=None) as raised:
        ops.line_make(**{**LINE, "output": tmp_path / "x.csv", **given})
    assert said in str(raised.value)
    assert not (tmp_path / "x.csv").exists()


def test_what_is_missing_is_named(tmp_path):
    with pytest.raises(MissingError, match=r"^speed: is missing$"):
        ops.line_make(output=tmp_path / "x.csv", pixel_hz=30)


def test_a_file_is_kept_where_force_says_so(tmp_path):
    ops.line_make(**LINE, output=tmp_path / "a.csv")
    ops.line_make(**LINE, output=tmp_path / "a.csv")
    with pytest.raises(UserError, match="already exists"):
        ops.line_make(**LINE, output=tmp_path / "a.csv", force=False)


def test_a_machine_file_gives_defaults(tmp_path):
    (tmp_path / "machine.toml").write_text(
        'clock.pixel = "30 Hz"\nboards.main.kind = "mega"\n'
        'motors.X = { axis = 0, kind = "plain", steps_per_unit = "400 steps/mm", '
        'limits.max_acceleration = "9 mm/s2" }\n'
    )
    made = ops.line_make(
        speed="12mm/s", length="20mm", output=tmp_path / "a.csv", machine=tmp_path / "machine.toml"
    )
    assert made["steps"] == 8000 and made["pixel_hz"] == "30/1"


def test_no_machine_file_is_looked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "machine.toml").write_text("nonsense")
    assert ops.line_make(**LINE, output="a.csv").fine


def test_the_ends_of_a_range_of_times_are_in_it():
    kind = Time("s", 0.05, 3600)
    assert [kind.read(text) for text in ("0.05s", "50ms", "60min")] == [0.05, 0.05, 3600]
    assert kind.read(0.05) == 0.05
    with pytest.raises(UserError, match=r"0.0499s is not in the range 0.05 to 3600 s"):
        kind.read("0.0499s")


@pytest.mark.parametrize("words", ["board_move", "board_upload", "board_home"])
def test_two_frequencies_for_a_board_are_refused(words, tmp_path):
    """The board's own divider is not known before it is asked: one would win in silence."""
    place = tmp_path / "x.csv"
    given = {"steps": 9} if words == "board_move" else {"decode": "plain"}
    both = {"clock_hz": 100, "pixel_hz": 30}
    with pytest.raises(UserError, match=r"^clock_hz and pixel_hz: one of them says the other$"):
        getattr(ops, words)(place, port="/dev/none", **given, **both)


def test_functions_pass_between_processes():
    assert pickle.loads(pickle.dumps(ops.line_make)) is ops.line_make


def test_names_that_are_not_there():
    assert "line_make" in dir(ops) and not hasattr(ops, "line_unmake")


def test_a_kind_says_what_python_gives():
    assert issubclass(Choice, Kind) and Choice(["a", "b"]).python == "Literal['a', 'b']"


def test_every_front_end_runs_requests_in_one_place(monkeypatch, tmp_path, invoke):
    seen = []
    finish = perform.finish
    monkeypatch.setattr(
        perform, "finish", lambda request, desk: seen.append(request) or finish(request, desk)
    )
    ops.line_make(**LINE, output=tmp_path / "a.csv")
    invoke("line", "make", "--speed", 1000, "--max-acceleration", 100, "--pixels", 60,
           "--pixel-hz", 30, "-o", "b.csv")  # fmt: skip
    first, second = seen
    assert first.speed.value == second.speed.value and first.pixels == second.pixels == 60


def test_an_empty_list_is_no_value(tmp_path):
    with pytest.raises(MissingError, match=r"^csv: is missing$"):
        ops.sim([], board="mega", decode="plain", pixel_hz=30, out=tmp_path / "run")


def test_results_and_errors_go_through_a_pool():
    move = {"profile": natives.root() / "tools/data/AccProf-fast-move.csv", "pixel_hz": 30}
    made = ops.move_show(**move, steps=900)
    copy = pickle.loads(pickle.dumps(made))
    assert copy == made and copy.page() == made.page() and "position" in made.page()
    wrong = (({"steps": 0.5}, FieldError), ({"profile": 5}, FieldError), ({}, MissingError))
    for given, kind in wrong:
        with pytest.raises(kind) as raised:
            ops.move_show(**{**move, **given})
        copied = pickle.loads(pickle.dumps(raised.value))
        assert type(copied) is kind and str(copied) == str(raised.value)


def test_an_error_that_quotes_braces_goes_through_a_pool(tmp_path):
    table = tmp_path / "{x}.csv"
    table.write_text("p1,p2\n0,0\n1,2\n5,3\n")
    with pytest.raises(AskedError, match=r"\{x\}.*: is not a circle, so transition is") as raised:
        ops.trajectory_compensate(table, play=3, pixel_hz=30, output=tmp_path / "made.csv")
    copied = pickle.loads(pickle.dumps(raised.value))
    assert type(copied) is AskedError and str(copied) == str(raised.value)


def test_what_needs_a_machine_file_says_so_in_the_words_of_its_caller(tmp_path, invoke):
    with pytest.raises(AskedError, match=r"^no machine file: machine FILE, "):
        ops.plan(tmp_path / "p.pmc", out=tmp_path / "plan")
    done = invoke("plan", "p.pmc", "--machine", "none", status=2)
    assert "no machine file: --machine FILE, " in done.stderr

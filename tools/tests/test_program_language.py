# SPDX-License-Identifier: MIT
"""The language around moves: the frame of a program, labels, comments, variables, RAPID."""

import math
from random import Random

import pytest

from pixstep.programs.expressions import FUNCTIONS
from pixstep.programs.language import ProgramError, read
from pixstep.programs.moves import Dwell
from programbench import events, planned, setup

NO_LIMIT = 1e9
PLAIN = "LINEAR ABS TA10 TS0 TM100\nX400\nY200\n"


def ends(text):
    """Return where the moves of a program end."""
    return [move.target for move in events(text, setup(1, 2)) if not isinstance(move, Dwell)]


def value(expression, before=""):
    """Return what an expression of a program is worth."""
    return ends(f"TS0 TA5 TM9\n{before}\nX({expression})")[-1][0]


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + PLAIN,
        "OPEN PROG 1 CLEAR\n" + PLAIN + "CLOSE\n",
        "CLOSE\nopen prog17\nCLEAR\n" + PLAIN + "close ; end\n; more\n\x1a",
        PLAIN.replace("LINEAR", "LIN").replace("\n", "\r\n"),
        "N10 " + PLAIN.replace("\nX", "\nN20:X").replace("\nY", "\n  N30 Y"),
        "/* begins\nX1 */ " + PLAIN.replace("\nX400", " // a\n/* b */X400 /* c */ ; d /* e"),
        "(A PROGRAM OF CAM (2D))\n" + PLAIN.replace("X400", "X400 (to the right)"),
        "P1=100 Q(P1/50)=P1*2\n" + PLAIN.replace("400", "(P1*4)").replace("Y200", "Y(Q2)"),
        "P1 = 1e0\n".replace("e0", "") + PLAIN.replace("TA10", "TA(P1*10)"),
    ],
)
def test_what_stands_around_a_program(text):
    assert ends(text) == [(400, 0), (400, 200)]
    assert events(text, setup(1, 2)) == [
        move._replace(line=found.line)
        for move, found in zip(events(PLAIN, setup(1, 2)), events(text, setup(1, 2)), strict=True)
    ]


def test_columns_stand_where_they_are_in_the_file():
    with pytest.raises(ProgramError, match=r"p\.pmc:2:13: unknown word 'Bad'"):
        ends("/* a\n b */ TM9   Bad")


@pytest.mark.parametrize(
    ("expression", "worth"),
    [
        ("1+2*3", 7), ("(1+2)*3", 9), ("7-2-1", 4), ("24/4/2", 3), ("-2*-3", 6), ("2*-(1+2)", -6),
        ("17%5", 2), ("-1%5", 4), ("--3", 3), ("SIN(30)*100", 50), ("cos(60) *100", 50),
        ("ATAN(1)", 45), ("ASIN(1)+ACOS(1)", 90), ("TAN(45)", 1), ("SQRT(16)", 4), ("ABS(-3)", 3),
        ("INT(2.9)", 2), ("INT(-2.1)", -3), ("EXP(LN(5))", 5), ("P1+Q(P1)", 12), (".5+5.", 5.5),
        ("+".join(["1"] * 1500), 1500),
    ],
)  # fmt: skip
def test_arithmetic(expression, worth):
    assert value(expression, "P1=5 Q5=7") == pytest.approx(worth, abs=1e-9)


def test_random_arithmetic_is_that_of_python():
    rng = Random(3)

    def text(depth):
        if depth == 0 or rng.random() < 0.2:
            return f"{rng.uniform(0, 9):.{rng.randrange(4)}f}"
        kind = rng.randrange(3)
        if kind == 0:
            return f"({text(depth - 1)})"
        if kind == 1:
            return f"{rng.choice('+-')}{text(depth - 1)}"
        return f"{text(depth - 1)}{rng.choice(['+', '-', ' * ', '/'])}{text(depth - 1)}"

    tried = 0
    for _ in range(600):
        expression = text(5)
        try:
            worth = eval(expression)  # made above of numbers and signs alone
        except ZeroDivisionError:
            continue
        if abs(worth) < 1e6:
            tried += 1
            assert value(expression) == pytest.approx(worth, rel=1e-12, abs=1e-9)
    assert tried > 300


def test_variables_have_the_value_of_where_they_stand():
    text = "INC TS0 TA5 TM9 P1=10\nX(P1) P1=P1+5 Y(P1)\nP1=P1*2\nX(P1)"
    assert ends(text) == [(10, 15), (40, 15)]


def test_every_function_is_known_to_the_message():
    for name in FUNCTIONS:
        with pytest.raises(ProgramError, match=f"a function: .*{name}"):
            value("FOO(1)")


BAD = {
    "SPLINE1": "1:1: unknown word 'SPLINE1', known are: LINEAR, RAPID, CIRCLE1, CIRCLE2, ABS, INC, "
    "FRAX, TA, TS, TM, F, DWELL, DELAY, X Y Z A B C U V W, I J R, variables P1=... and Q1=..., "
    "labels N1, OPEN PROG 1, CLEAR, CLOSE",
    "WHILE(P1<3)": "1:1: unknown word 'WHILE', known",
    "IF(P1=3)": "1:1: unknown word 'IF', known",
    "RETURN": "1:1: unknown word 'RETURN', known",
    "X0,5": "1:3: ',5': a decimal point is expected, as in 12.5",
    "TA10 X1,Y2": "1:8: ',Y2': expected a word of the language: LINEAR",
    "X1\0": "1:3: '\\x00': expected a word of the language: LINEAR",
    "X4 N20": "1:4: N20: a label is N and a whole number and begins a line",
    "N1.5 X4": "1:1: N1: a label is N and a whole number and begins a line",
    "N X4": "1:1: N: a label is N and a whole number and begins a line",
    "M1=1": "1:1: M1: of variables a program has P and Q",
    "I5113=10": "1:1: I5113: of variables a program has P and Q",
    "&1 #1->X": "1:1: '&1 #1->X': expected a word of the language: LINEAR",
    "TM9 X(P3)": "1:5: X(P3): P3 has no value yet: give it one, P3=...",
    "X(1/0)": "1:1: X(1/0): division by 0",
    "X(5%0)": "1:1: X(5%0): rest of a division by 0",
    "X(SQRT(0-1))": "1:1: X(SQRT(0-1)): SQRT(-1) is not a number",
    "X(EXP(1000))": "1:1: X(EXP(1000)): the result is too large",
    "P9000=1": "1:1: P9000=1: there is no variable P(9000): 0 to 8191",
    "P(1/2)=1": "1:1: P(1/2)=1: there is no variable P(0.5): 0 to 8191",
    "P1": "1:1: P1: a variable gets a value, P1=5, or is one, X(P1)",
    "P1=": "1:4: the line ends: expected a number, P1, Q1 or a function",
    "X(1+": "1:5: the line ends: expected a number",
    "X(1": "1:4: the line ends: expected )",
    "X(" + "(" * 2000: "1:43: '((((",
    "X" + "9" * 400: "1:1: X99999999999999999999999...: is too large",
    "X5 (P1+2)": "1:4: '(P1+2)': a bracket that belongs to no word",
    "(no end": "1:1: '(no end': a bracket that belongs to no word",
    "ABS(X,Q)": "1:4: '(X,Q)': expected axes, as (X,Y)",
    "/* no end": "1:1: /* without its */",
    "OPEN PLC 1": "1:1: OPEN: expected OPEN PROG and a number",
    "OPEN PROG 1\nOPEN PROG 2": "2:1: OPEN: stands once, before all statements",
    "TA5\nCLEAR": "2:1: CLEAR: stands once, before all statements",
    "OPEN PROG 1\nCLOSE\nTA5": "3:1: 'TA5': the program ends at CLOSE, a file has one",
    "\ufffd\ufffdT\0A\0": "1:1: this is not UTF-8: save the program as UTF-8",
}


@pytest.mark.parametrize("text", BAD)
def test_a_mistake_says_where_and_what_would_be_right(text):
    with pytest.raises(ProgramError) as refused:
        ends(text)
    assert str(refused.value).startswith(f"p.pmc:{BAD[text]}")
    assert "\n" not in str(refused.value)


def test_no_text_ends_in_anything_but_a_mistake_of_the_program():
    rng = Random(1)
    pieces = [*"XYPQIN()=+-*/%.,;:0123456789 \t", "ABS", "INC", "SIN(", "OPEN PROG 1", "CLOSE",
              "//", "/*", "*/", "P1=", "RAPID", "\u00e4", "\ufeff", "$", "TA5", "F("]  # fmt: skip
    refused = 0
    for _ in range(3000):
        text = "".join(rng.choice(pieces) for _ in range(rng.randrange(1, 30)))
        try:
            list(read("p.pmc", text.splitlines()))
        except ProgramError as error:
            refused += 1
            assert "\n" not in str(error)
    assert 1000 < refused < 3000


@pytest.mark.parametrize("mode", ["lookahead", "mode1"])
@pytest.mark.parametrize("smooth", [False, True])
def test_rapid_is_as_fast_as_the_motors_can_from_rest_to_rest(mode, smooth):
    """Far: 2000 counts at 5 counts/ms, 0.5 counts/ms2; near: no time to come to speed."""
    of = setup([0.5, NO_LIMIT], 2, hz=200, speed=[5, NO_LIMIT], smooth=smooth)
    pixel = of.pixel_ms
    speed, gain = of.motors[0].planned_speed(pixel), of.motors[0].planned_acceleration(pixel)
    for length, least in (
        (2000, 2000 / speed + speed / gain),
        (20, 2 * math.sqrt(20 / gain)),
    ):
        counts, report = planned(f"RAPID X{length} Y50", of, mode=mode)
        assert counts.sum(axis=0).tolist() == [length, 50]
        assert report.total_ms == pytest.approx(least, rel=1e-9)
        assert report.whole and not report.slowed_moves
    both = planned("RAPID X2000\nY50\nLINEAR INC TS0 TA10 TM100 Y50", of, mode=mode)[1]
    alone = [
        planned(text, of, mode=mode)[1].total_ms
        for text in ("RAPID X2000", "RAPID Y50", "INC TS0 TA10 TM100 Y50")
    ]
    assert both.total_ms == pytest.approx(sum(alone), rel=1e-9)  # nothing is blended

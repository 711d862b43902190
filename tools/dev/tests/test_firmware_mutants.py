# SPDX-License-Identifier: MIT
"""The mutation run: which changes a source offers, and what is said to have become of each."""

import json
import subprocess
from collections import Counter

import pytest

from effort import cases
from pixstep import natives
from pixstep.errors import UserError
from pixstep_dev.mutants import assembly, campaign, judged, operators, programs, record, stages
from pixstep_dev.mutants.campaign import MutantsOutcome, MutantsPlan, MutantTrial
from pixstep_dev.mutants.stages import StageVerdict

CODE = """\
#include <a-b.h> // 1 + 1
#define SIZE 0x10u
/* 1 + 1 */
static const char *text = "1 + 1";
bool f(int16_t a)
{
    _Static_assert(sizeof a == 2, "size");
    int16_t b = (int16_t)-a;
    g(b,
      a);
    for (; b < a; b++) {
        b |= (uint8_t)~a;
    }
    if (!a && b) {
        return a >= b;
    }
    switch (a) {
    case 3:
        break;
    }
    return true;
}
"""


def changes(text, kind):
    """Return what each mutant of a kind puts where."""
    found = operators.mutants("a.c", text)
    return [(one.line, one.right, one.wrong) for one in found if one.kind == kind]


def test_each_operator_is_changed_where_it_stands():
    assert changes(CODE, "relation") == [
        (11, "<", "<="), (11, "<", ">="), (15, ">=", "<"), (15, ">=", ">"),
    ]  # fmt: skip
    assert changes(CODE, "arithmetic") == [(11, "++", "--")]
    assert changes(CODE, "constant") == [
        (2, "0x10u", "0x11u"), (2, "0x10u", "0xFu"), (18, "3", "2"), (18, "3", "4"),
    ]  # fmt: skip
    assert changes(CODE, "logic") == [
        (14, "!", ""), (14, "!a && b", "!(!a && b)"), (14, "&&", "||"),
    ]  # fmt: skip
    assert changes(CODE, "bits") == [(12, "|=", "&="), (12, "~", "")]
    assert changes(CODE, "return") == [(15, "a >= b", "!(a >= b)"), (21, "true", "false")]


def test_statements_go_and_lines_stay():
    assert changes(CODE, "statement") == [
        (9, "g(b,\n      a);", ";\n"), (12, "b |= (uint8_t)~a;", ";"), (19, "break;", ";"),
    ]  # fmt: skip
    for mutant in operators.mutants("a.c", CODE):
        changed = mutant.apply(CODE)
        assert changed != CODE
        assert changed.count("\n") == CODE.count("\n")
    with pytest.raises(ValueError, match="is no longer"):
        operators.mutants("a.c", CODE)[0].apply("something else")


ASSEMBLY = """\
#define FIRST r18 \\
    adc r1, r2
.macro pass from
1:  adc r20, \\from    ; adc r20, r21
    brne 1b
    ldd r24, Z + PLACE_OF + 1
    sbiw r26, 1
    pass_on r20, r21
.endm
function take
    rjmp 1b
end_function take
"""


def test_of_an_instruction_one_part_is_changed():
    found = assembly.mutants("a.S", ASSEMBLY)
    assert [(one.line, one.kind, one.right, one.wrong) for one in found] == [
        (4, "arithmetic", "adc", "add"),
        (4, "statement", "adc r20, \\from", "nop"),
        (4, "register", "r20", "r21"),
        (5, "relation", "brne", "breq"),
        (5, "statement", "brne 1b", "nop"),
        (6, "statement", "ldd r24, Z + PLACE_OF + 1", "nop"),
        (6, "register", "r24", "r25"),
        (6, "constant", "1", "2"),
        (6, "constant", "1", "0"),
        (7, "arithmetic", "sbiw", "adiw"),
        (7, "statement", "sbiw r26, 1", "nop"),
        (7, "register", "r26", "r24"),
        (7, "constant", "1", "2"),
        (7, "constant", "1", "0"),
    ]
    assert {one.inside for one in found} == {"pass"}
    assert found[0].apply(ASSEMBLY).splitlines()[3] == "1:  add r20, \\from    ; adc r20, r21"


def test_a_pattern_chooses_the_sources():
    few = campaign.offered(campaign.chosen(MutantsPlan(1, only="/clock_filter")))
    assert {one.file for one in few} == {
        "firmware/core/clock/clock_filter.c", "firmware/core/clock/clock_filter.h",
    }  # fmt: skip
    assert all(
        one.file.endswith((".S", ".inc"))
        for one in campaign.offered(campaign.chosen(MutantsPlan(1, assembly=True)))
    )


EVEN = "firmware/core/stream/even.c"


def of_even(right, wrong):
    """Return a change of even.c; `right` is there once."""
    text = (natives.root() / EVEN).read_text(encoding="utf-8")
    assert text.count(right) == 1
    return operators.Mutant(EVEN, 0, "relation", text.index(right), right, wrong, "", right, wrong)


# The native suites of the host build belong to the long check; those on AVR are built in both.
STAGE = cases("avr", "native")


@pytest.fixture(scope="module")
def suites(simulator, tmp_path_factory):
    """Return a campaign by one stage, which is asked about one mutant after the other.

    In the quick check three of the suites stand for all: each is linked anew for each mutant.
    """
    made = campaign.MutantsCampaign(
        MutantsPlan(1, stages=(STAGE,)), tmp_path_factory.mktemp("mutants")
    )
    if STAGE == "avr":
        build = made.stages.builds["mega"]
        chosen = [build.program(f"host_tests/test_{name}.elf") for name in ("axis", "even", "feed")]
        made.stages.suites = lambda stage: chosen
    return made


def tree():
    """Return what git says of the sources."""
    command = ["git", "status", "--porcelain", "--", "firmware", "host_tests"]
    done = subprocess.run(command, cwd=natives.root(), capture_output=True, check=False)
    return done.stdout


def test_a_wrong_start_is_killed_by_the_suite_of_its_file(suites):
    before = tree()
    trial = suites.run(of_even("(uint16_t)(steps - 1u)", "(uint16_t)(steps + 1u)"))
    assert (trial.fate, trial.by) == (STAGE, f"{STAGE} even")
    assert tree() == before


def test_a_quicker_way_to_the_same_survives(suites):
    """The general way gives the same for a whole round: other code, the same behaviour."""
    trial = suites.run(of_even("steps == even->steps", "0"))
    assert (trial.fate, trial.passed) == ("survived", (STAGE,))


@pytest.mark.parametrize(("wrong", "same"), [("steps - 0x1u", True), ("steps + 1u", False)])
def test_the_same_code_is_equivalent(suites, tmp_path, wrong, same):
    file, changed = natives.root() / EVEN, programs.Workshop(tmp_path / "changed")
    mutant = of_even("steps - 1u", wrong)
    changed.change(file, mutant.apply(file.read_text(encoding="utf-8")))
    plain = programs.Workshop(tmp_path / "plain")
    assert suites.stages.equivalent(changed, plain, file) == same
    if STAGE == "native":  # the stage behind which this is asked
        assert (suites.run(mutant).fate == "equivalent") == same


def test_what_does_not_compile_is_no_mutant(suites):
    assert suites.run(of_even("steps - 1u", "steps - ")).fate == "invalid"


def test_an_image_is_linked_of_the_changed_objects(simulator, tmp_path):
    """Unless a change is one, the image is the build's to the byte."""
    build, workshop = programs.Build("uno"), programs.Workshop(tmp_path)
    program = build.program("firmware/pixstep-uno.elf")
    image = (build.folder / program.target).read_bytes()
    file = natives.root() / EVEN
    text = file.read_text(encoding="utf-8")
    for wrong, same in (("steps - 0x1u", True), ("steps + 1u", False)):
        workshop.change(file, of_even("steps - 1u", wrong).apply(text))
        assert (workshop.link(program).read_bytes() == image) == same


def folders():
    """Return what runs have left in the build folder."""
    return sorted((natives.root() / "build" / "mutants").glob("*"))


def test_ctrl_c_leaves_nothing(suites, monkeypatch):
    before, sources = folders(), tree()
    monkeypatch.setattr(stages, "Stages", lambda *_: suites.stages)
    monkeypatch.setattr(campaign.MutantsCampaign, "measure", lambda self: None)
    monkeypatch.setattr(suites.stages, "try_stage", lambda *_: StageVerdict("native", "a suite"))
    shown = []

    def press(share):
        shown.append(share)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        campaign.run(MutantsPlan(2, stages=("native",)), press)
    assert len(shown) == 1
    assert folders() == before
    assert tree() == sources


def outcome(*fates):
    """Return an outcome with a mutant for each fate."""
    text = "bool f(void)\n{\n" + "    return a < b;\n" * len(fates) + "}\n"
    found = [one for one in operators.mutants("f.c", text) if one.wrong == "<="]
    return MutantsOutcome(
        MutantsPlan(3), "digest", 9, [MutantTrial(*pair) for pair in zip(found, fates, strict=True)]
    )


def test_figures_and_survivors_are_recorded():
    made = outcome("native", "survived", "equivalent", "invalid")
    assert "50.0 % are killed" in record.summary(made, {})
    assert "### Survivors that are not judged" in record.markdown(made, {})
    survivor = made.survivors[0].mutant
    assert survivor.inside == "f"
    known = {judged.key(survivor): judged.MutantJudgement("equivalent", "b is odd")}
    assert "100.0 % are killed" in record.summary(made, known)
    assert "return a <= b;`\n  b is odd" in record.markdown(made, known)


def test_an_outcome_is_read_again(tmp_path):
    made, path = outcome("native", "survived"), tmp_path / "mutants.json"
    path.write_text(json.dumps(campaign.facts(made)))
    assert campaign.read(path) == made
    for text in ("{}", "[", '{"plan": 1}'):
        path.write_text(text)
        with pytest.raises(UserError, match=r"not what .* prints"):
            campaign.read(path)


def test_kept_judgements_are_judgements(tmp_path):
    """Each of one mutant of the sources as they are: what is judged is still there."""
    paths = {natives.root() / key[0] for key in judged.read()}
    there = Counter(judged.key(one) for one in campaign.offered(sorted(paths)))
    assert {key: there[key] for key in judged.read() if there[key] != 1} == {}
    path = tmp_path / "table.toml"
    path.write_text(
        '[[judged]]\nfile="a"\ninside="f"\nwas="b"\nbecomes="c"\nverdict="fine"\nwhy="d"\n'
    )
    with pytest.raises(UserError, match="no judgement"):
        judged.read(path)
    with pytest.raises(UserError, match="No such file"):
        judged.read(tmp_path / "none.toml")

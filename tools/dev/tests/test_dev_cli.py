# SPDX-License-Identifier: MIT
"""Two commands, one direction: pixstep offers `bench` without importing what proves it."""

import subprocess
import sys

import pytest
from click.testing import CliRunner

from pixstep import natives
from pixstep.cli.main import main
from pixstep_dev.cli.main import main as main_dev

OFFERED = {
    "bench", "campaign", "docs", "fuzz", "jobs", "motor-record", "mutants", "robustness", "wheels",
    "costs", "guarantee", "release", "site",
}  # fmt: skip

# Runs pixstep where pixstep_dev cannot be found, and says whether it tried to import it.
WITHOUT_IT = """
import sys
class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "pixstep_dev":
            raise ModuleNotFoundError(f"No module named {name!r}", name="pixstep_dev")
sys.meta_path.insert(0, Refuse())
from pixstep import natives
from pixstep.cli.main import main
main(prog_name="pixstep")
"""


def without_it(*words):
    return subprocess.run(
        [sys.executable, "-c", WITHOUT_IT, *words],
        capture_output=True, text=True, check=False, env={"PYTHONPATH": ":".join(sys.path)},
    )  # fmt: skip


def test_what_each_command_offers():
    assert set(main_dev.commands) == OFFERED
    assert OFFERED & set(main.commands) == {"bench"}


@pytest.mark.parametrize("words", [["robustness"], ["fuzz"], ["jobs"]], ids=" ".join)
def test_help_of_every_command(words):
    text = CliRunner().invoke(main_dev, [*words, "--help"]).output
    for row in text.partition("Commands:")[2].strip().splitlines():
        name, about = row.split(maxsplit=1)
        assert about.endswith(".") and not about.endswith("..."), row
        done = CliRunner().invoke(main_dev, [*words, name, "--help"])
        assert done.exit_code == 0 and "Usage" in done.output


def test_bench_is_the_same_in_both():
    by_product, by_proof = (CliRunner().invoke(command, ["bench", "--help"])
                            for command in (main, main_dev))  # fmt: skip
    assert by_product.exit_code == 0 and "--compare" in by_product.output
    assert by_product.output == by_proof.output
    assert CliRunner().invoke(main, ["bench", "--only", "beauty"]).exit_code == 2


def test_without_the_proof_bench_is_refused_in_one_line():
    done = without_it("bench", "--quick")
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.count("\n") == 1 and "part of pixstep-dev" in done.stderr


def test_without_the_proof_all_else_works():
    done = without_it("--help")
    assert done.returncode == 0 and " bench " not in done.stdout, done.stderr
    assert without_it("line", "make", "--help").returncode == 0


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (("gates", "--board", "mega", "--rest-s", "nan", "nan"), "nan nan: the least value comes"),
        (("gates", "--board", "mega", "--rest-s", "5", "1"), "5 1: the least value comes first"),
        (("homings", "--board", "mega", "--bounce-ticks", "20", "5"), "20 5: the least value"),
        (("holes", "--board", "uno", "--axes", "4"), "none of the boards has so many axes"),
    ],
)
def test_a_campaign_of_nothing_is_refused(words, wanted):
    done = CliRunner().invoke(main_dev, ["robustness", *words])
    assert done.exit_code == 2 and wanted in done.output


@pytest.mark.parametrize(("script", "says"), [("setup", "tools/setup run "), ("build", "images")])
def test_the_scripts_of_a_clone_explain_themselves(script, says):
    for word in ("-h", "--help"):
        done = subprocess.run(
            [natives.root() / "tools" / script, word], capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, "")
        assert says in done.stdout and "SPDX" not in done.stdout and "set -" not in done.stdout
    wrong = subprocess.run(
        [natives.root() / "tools" / script, "nonsense"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert wrong.returncode != 0 and "what is 'nonsense'" in wrong.stderr

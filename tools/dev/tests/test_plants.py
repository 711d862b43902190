# SPDX-License-Identifier: MIT
"""Planted defects follow their sources: the text that each one changes is there exactly once.

The campaigns that plant them take minutes and are not part of the quick check; a source whose text
has changed is found here.
"""

import explore_plants
import explore_two_plants
import orders_plants
import pytest
import sim_plants
from common import ROOT, build_folder
from planting import compile_words, link_words, swapped

from pixstep.errors import UserError
from pixstep_dev.fuzzing import defects, sources

HOST = build_folder("host")


def about(plant):
    """Return what a plant is, as the name of a test."""
    return plant.about


@pytest.mark.parametrize("defect", defects.DEFECTS, ids=about)
def test_the_fuzzers_defects_can_be_planted(defect):
    text = (ROOT / "firmware" / defect.file).read_text(encoding="utf-8")
    assert defect.wrong in sources.planted_text(defect) != text


def test_a_defect_whose_text_is_gone_names_its_file():
    defect = sources.Defect("server", defects.SERVER, "no such text", "", "nothing")
    with pytest.raises(UserError, match=r"core/wire/server\.c: the defect 'nothing' cannot be"):
        sources.planted_text(defect)


@pytest.mark.parametrize("plant", sim_plants.PLANTS, ids=about)
def test_the_simulators_defects_can_be_planted(plant):
    text = (ROOT / "sim" / plant.file).read_text(encoding="utf-8")
    assert swapped(text, plant.right, plant.wrong, plant.file) != text


@pytest.mark.parametrize("plant", explore_plants.PLANTS + explore_two_plants.PLANTS, ids=about)
def test_the_explorers_defects_can_be_planted(plant, tmp_path):
    assert explore_plants.plant(plant, tmp_path)


@pytest.mark.parametrize("plant", orders_plants.plants(), ids=about)
def test_the_defects_of_orders_can_be_planted(plant, tmp_path):
    assert orders_plants.write_changed(plant, tmp_path)


def test_a_plant_whose_text_is_gone_names_its_file():
    with pytest.raises(ValueError, match=r"timer16\.c: 'no such text' is not there exactly once"):
        swapped("some text", "no such text", "", "timer16.c")


@pytest.mark.parametrize("source", sorted({plant.file for plant in sim_plants.PLANTS}))
def test_a_plant_is_compiled_for_the_simulator(source):
    """Other programs compile the timers' model too: their objects are not the simulator's."""
    words = compile_words(HOST, ROOT / "sim" / source, sim_plants.TARGET)
    assert words[words.index("-o") + 1] in link_words(HOST, sim_plants.TARGET)

# SPDX-License-Identifier: MIT
"""What motor records keep over a restart of their server."""

import json

import pytest

from ideal_drive import IdealDrive, Stepper
from iocbench import Noted, served, until
from pixstep import UserError
from pixstep.ioc.saved import Saved, SavedRecord

REC = "T:m"


def drive(position=0.0):
    """Return an ideal stepper that stands somewhere."""
    return {REC: IdealDrive(Stepper(position=position, home=1e8))}


def test_settings_are_kept_and_the_position_is_that_of_the_board(monkeypatch, tmp_path):
    state = tmp_path / "ioc.json"
    with served(monkeypatch, state=state) as (host, wire):
        wire.put(f"{REC}.VELO", 30.0)
        wire.put(f"{REC}.OFF", 1.5)
        wire.put(f"{REC}.DESC", b"mine")
        wire.put(REC, 4.5)
        until(lambda: wire.value("T:IOC:SAVED") != "")
    assert json.loads(state.read_text())["motors"][REC]["fields"]["DVAL"] == 3.0
    with served(monkeypatch, state=state, drives=drive(300)) as (host, wire):
        assert wire.value(f"{REC}.VELO") == 30
        assert wire.value(f"{REC}.DESC") == "mine"
        assert (wire.value(REC), wire.value(f"{REC}.RBV")) == (4.5, 4.5)
        assert host.drives[REC].motor.edges == []


@pytest.mark.parametrize(("restores", "steps"), [(2, 300), (0, 0), (1, 300)])
def test_a_board_that_lost_its_count_gets_the_position_back_by_rstm(
    monkeypatch, tmp_path, restores, steps
):
    state = tmp_path / "ioc.json"
    fields = {REC: {"RSTM": restores}}
    with served(monkeypatch, state=state, fields=fields) as (_, wire):
        wire.put(REC, 3.0)
    with served(monkeypatch, state=state, fields=fields, drives=drive()) as (host, wire):
        until(lambda: host.drives[REC].motor.steps == steps)
        assert wire.value(f"{REC}.RBV") == steps / 100


def test_a_server_that_dies_in_a_move_has_lost_nothing(monkeypatch, tmp_path):
    state = tmp_path / "ioc.json"
    with served(monkeypatch, state=state) as (host, wire):
        wire.begin(REC, 40.0)
        until(lambda: json.loads(state.read_text())["motors"][REC]["moving"]
              if state.exists() else False)  # fmt: skip
        died = state.read_bytes()
        assert wire.value(f"{REC}.DMOV") == 0
    kept = json.loads(died)["motors"][REC]["fields"]["DVAL"]
    assert 0 < kept < 40
    state.write_bytes(died)
    with served(monkeypatch, state=state, drives=drive(1234)) as (host, wire):  # the board went on
        assert wire.value(f"{REC}.RBV") == wire.value(REC) == 12.34
        assert host.log.facts("was moving when the last IOC ended") == [{"motor": REC}]
    state.write_bytes(died)
    with served(monkeypatch, state=state, drives=drive()) as (host, wire):  # it was off
        until(lambda: wire.value(f"{REC}.RBV") == pytest.approx(kept))


def test_the_machine_file_wins_where_it_has_changed(tmp_path):
    saved = Saved(tmp_path / "ioc.json")
    given = {"EGU": "mm", "VELO": 1.0, "BDST": 0.1}
    record = {**dict.fromkeys(("DRBV",), 2.0), "VELO": 3.0, "BDST": 0.5}

    class Record(dict):
        def __missing__(self, field):
            return 0

    saved.note("m", given, Record(record), is_moving=False)
    assert saved.write()
    assert not saved.write()
    again = Saved(tmp_path / "ioc.json")
    kept = again.kept("m", given | {"VELO": 2.0})
    assert (kept.fields["VELO"], kept.fields["BDST"], kept.fields["DVAL"]) == (2.0, 0.5, 2.0)
    assert not kept.is_moving
    assert again.kept("m", given | {"EGU": "deg"}) == SavedRecord(given | {"EGU": "deg"})
    assert again.kept("other", given) == SavedRecord(given)


@pytest.mark.parametrize("restores", [0, 2])
@pytest.mark.parametrize(
    ("register", "position"),
    [(500, 25.0), (700, 27.0), (0, None)],  # as it was; it went on; it was reset
)
def test_a_position_that_was_set_is_kept_with_the_boards_count(
    monkeypatch, tmp_path, register, position, restores
):
    state = tmp_path / "ioc.json"
    fields = {REC: {"RSTM": restores}}
    with served(monkeypatch, state=state, fields=fields) as (_, wire):
        wire.put(f"{REC}.FOFF", 1)
        wire.put(f"{REC}.SET", 1)
        wire.put(REC, 20.0)  # the controller's position, where its register is 0
        wire.put(f"{REC}.SET", 0)
        wire.put(REC, 25.0)
    kept = json.loads(state.read_text())["motors"][REC]
    assert (kept["register_steps"], kept["offset_steps"]) == (500, 2000)
    if position is None:
        position = 25.0 if restores else 0.0
    with served(monkeypatch, state=state, fields=fields, drives=drive(register)) as (_, wire):
        until(lambda: wire.value(f"{REC}.RBV") == position)
        assert wire.value(REC) == position
        assert wire.put(REC, position + 1) == ""
        assert wire.value(f"{REC}.RBV") == position + 1


@pytest.mark.parametrize("text", ["", "{", "[]", '{"pixstep_ioc": 2, "motors": {}}',
                                  '{"pixstep_ioc": 1, "motors": {"m": {}}}'])  # fmt: skip
def test_a_file_that_is_none_is_refused_by_name(tmp_path, text):
    path = tmp_path / "ioc.json"
    path.write_text(text)
    with pytest.raises(UserError, match=r"ioc\.json: is not a file of `pixstep ioc`"):
        Saved(path)


def test_a_file_that_cannot_be_written_is_told_and_nothing_ends(monkeypatch, tmp_path):
    state = tmp_path / "folder" / "ioc.json"
    state.parent.mkdir()
    with served(monkeypatch, state=state) as (host, wire):
        until(lambda: wire.value("T:IOC:SAVED") != "")
        state.unlink()
        state.mkdir()
        wire.put(f"{REC}.VELO", 30.0)
        host.log.wait("not saved")
        assert wire.put(REC, 1.0) == ""
    assert isinstance(host.log, Noted)

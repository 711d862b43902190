# SPDX-License-Identifier: MIT
"""The file of a job: small, the same bytes each time, and not a byte of it can be another."""

import hashlib
import random
import time
import tomllib
import zipfile

import pyarrow.parquet
import pytest

import jobbench
from effort import cases
from pixstep.errors import RefusedError, UserError
from pixstep.jobs import archive, header, judging
from pixstep.jobs.job import Job
from pixstep.lines import exact

CHANGES = 2000


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    return jobbench.write_machine(tmp_path_factory.mktemp("machine"))


@pytest.fixture(scope="module")
def made(machine, tmp_path_factory):
    """Return a job, its file and the file's bytes."""
    path = tmp_path_factory.mktemp("job") / "a.pxjob"
    job = jobbench.make(machine)
    job.write(path)
    return job, path, path.read_bytes()


def refusal(path, data):
    """Return why a file of these bytes is refused."""
    path.write_bytes(data)
    with pytest.raises(RefusedError) as caught:
        Job.read(path)
    return str(caught.value)


def resealed(path, change):
    """Return the bytes of a job whose job.toml was changed and sealed again."""
    members = archive.unpack(path, path.read_bytes(), header.NAME)
    body = change(members[header.NAME].decode().partition("\n[seal]\n")[0])
    seal = hashlib.sha256(body.encode()).hexdigest()
    members[header.NAME] = f'{body}\n[seal]\nsha256 = "{seal}"\n'.encode()
    return archive.pack(members)


def test_what_is_written_is_read(made, machine):
    job, path, _ = made
    read = Job.read(path)
    assert (read.runs, read.header.id) == (job.runs, job.header.id)
    assert {key: read.shapes[key] for key in read.shapes} == dict(job.shapes)
    assert read.copies["machine.toml"] == machine.path.read_bytes()
    names = {"profiles/AccProfM39-30Hz-1.PRN", "profiles/turn.PRN", "profiles/move.csv"}
    assert names < set(read.copies)
    for name in names:
        same = machine.path.parent / name.removeprefix("profiles/")
        assert read.copies[name] == same.read_bytes()


def test_expected_positions_are_the_exact_ones(made):
    _, path, _ = made
    read = Job.read(path)
    for number in range(1, read.lines + 1):
        for name, line in read.line(number).items():
            start = read.runs_of(number)[name].start_steps
            places = [start + place for place in exact.expected_positions(line)]
            assert list(read.expected(number, name)) == places


def test_the_same_job_has_the_same_bytes(machine, made, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    first, again = (jobbench.make(machine).packed() for _ in range(2))
    assert first == again
    job, _, _ = made
    assert jobbench.make(machine).header.id == job.header.id


def test_other_programs_read_it(made):
    """A ZIP of stored members, TOML and Parquet: none of them needs pixstep."""
    _, path, _ = made
    with zipfile.ZipFile(path) as found:
        assert found.testzip() is None
        about = tomllib.loads(found.read("job.toml").decode())
        with found.open("lines.parquet") as file:
            lines = pyarrow.parquet.read_table(file)
        with found.open("shapes.parquet") as file:
            shapes = pyarrow.parquet.read_table(file)
    assert about["schema"] == 1 and about["line"]["pixels"] == 78
    assert lines.num_rows == 12 and shapes.num_rows == 4
    assert {len(row) for row in shapes.column("expected").to_pylist()} == {78}


def test_every_changed_byte_is_refused_and_its_member_named(made, tmp_path, machine):
    """2,000 random bytes of a job, each another one; in the long check of a large job."""
    job = jobbench.large(machine, lines=cases(40, 1000), pixels=cases(120, 500))
    data = job.packed()
    members = archive.unpack(tmp_path / "a.pxjob", data, header.NAME)
    chance = random.Random(1)
    named = 0
    for _ in range(CHANGES):
        at = chance.randrange(len(data))
        changed = bytearray(data)
        changed[at] ^= chance.randrange(1, 256)
        said = refusal(tmp_path / "b.pxjob", bytes(changed))
        assert "\n" not in said
        assert "the list of members" in said or any(name[:7] in said for name in members)
        named += any(f"member {name}" in said for name in members)
    assert named > CHANGES * 9 // 10


def test_the_member_that_is_named_has_the_changed_byte(made, tmp_path):
    _, path, data = made
    members = archive.unpack(path, data, header.NAME)
    for name, content in members.items():
        at = data.index(content) + len(content) // 2
        changed = bytearray(data)
        changed[at] ^= 0x40
        assert f"damaged in member {name}" in refusal(tmp_path / "c.pxjob", bytes(changed))


def test_cut_and_longer_files_are_refused(made, tmp_path):
    _, _, data = made
    for length in range(0, len(data), 7):
        said = refusal(tmp_path / "cut.pxjob", data[:length])
        assert "cut short" in said or "job.toml is not its first member" in said
    for more in (b"\0", b"PK", data):
        said = refusal(tmp_path / "long.pxjob", data + more)
        assert f"{len(more)} bytes follow the list of members" in said


def test_a_member_that_was_exchanged_is_refused(made, tmp_path):
    """A container that is right in itself: the sums name the member."""
    _, path, data = made
    members = archive.unpack(path, data, header.NAME)
    for name in members:
        other = archive.pack(members | {name: members[name] + b"\n"})
        wanted = f"member {name} is not as its s"  # sha256, or of job.toml its seal
        assert wanted in refusal(tmp_path / "d.pxjob", other)
        left = {one: content for one, content in members.items() if one != name}
        wanted = f"{name} is not its first" if name == header.NAME else f"{name} is missing"
        assert wanted in refusal(tmp_path / "e.pxjob", archive.pack(left))
    assert "member more is not as" in refusal(
        tmp_path / "f.pxjob", archive.pack(members | {"more": b""})
    )


def test_a_newer_schema_is_refused_by_name(made, tmp_path):
    _, path, _ = made
    newer = resealed(path, lambda body: body.replace("schema = 1", "schema = 2").replace(
        'by = "0.2.0"', 'by = "7.0.0"'))  # fmt: skip
    said = refusal(tmp_path / "g.pxjob", newer)
    assert "schema = 2: made by pixstep 7.0.0" in said and "newer pixstep" in said


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("resumable = true", "resumable = 3", "job.toml: resumable: "),
        ('kind = "image"', 'kind = "magic"', "job.toml: source.kind: "),
        ("lines = 4", "lines = -4", "job.toml: line.lines: "),
        ("resumable = true", "resumable = true\nmore = 1", "job.toml: more: "),
        ("resumable = true", "resumable =", "job.toml: "),
    ],
)
def test_a_wrong_value_is_one_line(made, tmp_path, old, new, said):
    _, path, _ = made
    told = refusal(tmp_path / "h.pxjob", resealed(path, lambda body: body.replace(old, new)))
    assert said in told and "\n" not in told


def rebuilt(path, change):
    """Return the bytes of a job whose members were changed, with all sums made right again."""
    members = archive.unpack(path, path.read_bytes(), header.NAME)
    about = header.read(path, members)
    about = change(members, about) or about
    members[header.NAME] = about.model_copy(update={"sha256": header.sums(members)}).text().encode()
    return archive.pack(members)


def test_members_that_do_not_fit_each_other_are_refused(made, tmp_path):
    """What only a program could make that is not pixstep: one line, no traceback."""
    _, path, _ = made

    def garbage(name):
        def change(members, about):
            members[name] = b"PAR1 nonsense"

        return change

    def lines(count):
        def change(members, about):
            return about.model_copy(update={
                "line": about.line.model_copy(update={"lines": count})})  # fmt: skip

        return change

    def other_shapes(members, about):
        members["shapes.parquet"] = archive.pack_shapes([])

    def no_profile(members, about):
        del members["profiles/turn.PRN"]

    for change, said in (
        (garbage("shapes.parquet"), "no table of shapes: "),
        (garbage("lines.parquet"), "no table of lines: "),
        (lines(3), "lines.parquet: not 3 lines of M39, M40, M41"),
        (lines(0), "lines.parquet: not 0 lines of M39, M40, M41"),
        (other_shapes, "a shape or a length that the job has not"),
        (no_profile, "member profiles/turn.PRN is missing"),
    ):
        told = refusal(tmp_path / "i.pxjob", rebuilt(path, change))
        assert said in told and "\n" not in told


def test_what_is_no_job(tmp_path):
    for data in (b"", b"PK", b"1,2\r\n" * 50, archive.pack({"machine.toml": b""}), bytes(99)):
        assert "no job file: job.toml is not its first member" in refusal(tmp_path / "x", data)
    with pytest.raises(UserError, match=r"nowhere\.pxjob: No such file"):
        Job.read(tmp_path / "nowhere.pxjob")


def test_a_file_is_written_whole_or_not_at_all(made, tmp_path, monkeypatch):
    job, _, data = made
    path = tmp_path / "a.pxjob"
    path.write_bytes(data)
    monkeypatch.setattr("pixstep.jobs.archive.pack_runs", lambda runs: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        job.write(path)
    assert path.read_bytes() == data and list(tmp_path.iterdir()) == [path]


def test_a_thousand_lines_are_below_a_megabyte_and_five_seconds(machine, tmp_path):
    """1,000 lines of 3 motors, 500 pixels: nearly 2,000 different ones."""
    begin = time.process_time()
    job = jobbench.large(machine)
    said = judging.judge(job, machine, lambda _: machine.path)
    size = job.write(tmp_path / "big.pxjob")
    seconds = time.process_time() - begin
    begin = time.process_time()
    read = Job.read(tmp_path / "big.pxjob")
    line = read.line(777)
    one = time.process_time() - begin
    print(f"{size} bytes, {len(job.shapes)} shapes, {seconds:.2f} s; one line read {one:.3f} s")
    assert said == [] and size < 1_000_000 and seconds < 5
    assert line["M40"].counts == job.line(777)["M40"].counts
    assert len(job.shapes) > 1900

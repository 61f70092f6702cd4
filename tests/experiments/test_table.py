"""The table: what is written is read, and nothing is ever lost."""

import json
import subprocess
import sys

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ao2viz import DecideBy
from ao2viz.experiments.measure import Evaluation
from ao2viz.experiments.plan import Schedule, Task
from ao2viz.experiments.provenance import Provenance, provenance
from ao2viz.experiments.sweep import missing
from ao2viz.experiments.table import SCHEMA, TableError, opened, read
from tests.experiments.evaluations import both_ways, evaluation, run

ONCE = Schedule((1000,), episodes=2)


def write(path, *rows: Evaluation):
    with opened(path) as table:
        table.add(rows)
    return path


def test_rows_come_back_as_they_went(tmp_path):
    rows = [
        evaluation(1.5, -2.25, of=run(3, levels=4, credit="return")),
        evaluation(7.0, of=run(3), decide_by=DecideBy.PATH, made_by=Provenance("9", None)),
    ]
    assert read(write(tmp_path / "r.parquet", *rows)) == rows


def test_any_parquet_reader_can_read_it(tmp_path):
    table = pq.read_table(write(tmp_path / "r.parquet", *both_ways(1.0, 3.0, of=run(3, levels=4))))
    row = table.to_pylist()[0]
    assert table.column_names == SCHEMA.names
    assert (row["env"], row["preset"], row["seed"]) == ("CartPole-v1", "anticipating", 3)
    assert json.loads(row["settings"]) == {"levels": 4}
    assert (row["steps"], row["decide_by"]) == (1000, "vote")
    assert (row["mean_return"], row["standard_error"]) == (2.0, 1.0)
    assert row["returns"] == [1.0, 3.0]
    assert (row["version"], row["commit"]) == provenance()


def test_a_row_that_is_there_stays(tmp_path):
    path = write(tmp_path / "r.parquet", *both_ways(1.0, 3.0))
    later = both_ways(9.0, 9.0), both_ways(4.0, 4.0, steps=2000)
    write(path, *later[0], *later[1])
    assert read(path) == [*both_ways(1.0, 3.0), *later[1]]


def test_what_is_missing_is_told(tmp_path):
    path = write(tmp_path / "r.parquet", *both_ways(of=run(0)), evaluation(of=run(1)))
    with opened(path) as table:
        assert table.holds(run(0), ONCE)
        assert not table.holds(run(1), ONCE), "It was evaluated by vote alone."
        assert not table.holds(run(0, levels=3), ONCE)
        assert not table.holds(run(0), Schedule((1000, 2000), episodes=2))
        tasks = [Task(run(seed), ONCE) for seed in range(3)]
        assert missing(table, tasks) == tasks[1:]


def test_another_number_of_episodes_is_refused(tmp_path):
    path = write(tmp_path / "r.parquet", *both_ways(1.0, 3.0))
    with opened(path) as table, pytest.raises(TableError, match=r"with 2 episodes, not 5.*another"):
        missing(table, [Task(run(), Schedule((1000,), episodes=5))])


def test_another_version_of_ao2viz_is_refused(tmp_path):
    path = write(tmp_path / "r.parquet", evaluation(made_by=Provenance("0.0.1", None)))
    with opened(path) as table:
        assert missing(table, []) == [], "Who adds nothing may read it."
        with pytest.raises(TableError, match=r"made by ao2viz 0\.0\.1, but this"):
            missing(table, [Task(run(7), ONCE)])


def test_another_commit_of_the_same_version_is_not(tmp_path):
    other = Provenance(provenance().version, "0123456789")
    path = write(tmp_path / "r.parquet", evaluation(made_by=other))
    with opened(path) as table:
        assert missing(table, [Task(run(7), ONCE)]) == [Task(run(7), ONCE)]


def foreign(change):
    rows = [SCHEMA.empty_table(), pa.table({"a": [1]})]
    return change(*rows)


FOREIGN = {
    "other columns": (lambda ours, other: other, "lacks env, preset.*also has a"),
    "a column more": (
        lambda ours, _: ours.append_column("x", pa.array([], pa.int64())),
        r"no table of a sweep: it also has x\.",
    ),
    "another type": (
        lambda ours, _: ours.set_column(3, "seed", pa.array([], pa.string())),
        "another type in seed",
    ),
    "a newer format": (
        lambda ours, _: ours.replace_schema_metadata({"ao2viz_results": "3"}),
        "newer ao2viz: its format is 3, and 2 is the newest known",
    ),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_a_foreign_table_is_refused_and_left_as_it_is(tmp_path, name):
    change, words = FOREIGN[name]
    path = tmp_path / "r.parquet"
    pq.write_table(foreign(change), path)
    before = path.read_bytes()
    with pytest.raises(TableError, match=words), opened(path):
        pass
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["r.parquet"]


@pytest.mark.parametrize("content", [b"", b"hello", b"PAR1" + bytes(100) + b"PAR1"])
def test_what_is_no_parquet_is_refused(tmp_path, content):
    (tmp_path / "r.parquet").write_bytes(content)
    with pytest.raises(TableError, match=r"r\.parquet is no sound Parquet file"):
        read(tmp_path / "r.parquet")


WRONG_VALUES = {
    "env": ("<script>alert(1)</script>", "plain text in env"),
    "version": ("`rm`", "plain text in version"),
    "preset": ("clever", "not a valid Preset"),
    "decide_by": ("luck", "not a valid DecideBy"),
    "settings": ("3", "a JSON object as settings"),
    "seed": (None, "a value in seed"),
    "returns": ([], "at least one episode"),
}


@pytest.mark.parametrize("column", WRONG_VALUES)
def test_values_that_no_sweep_has_written_are_refused(tmp_path, column):
    value, words = WRONG_VALUES[column]
    path = write(tmp_path / "r.parquet", evaluation())
    row = pq.read_table(path).to_pylist()[0] | {column: value}
    nullable = pa.schema([field.with_nullable(True) for field in SCHEMA])
    pq.write_table(pa.Table.from_pylist([row], nullable), path)
    with pytest.raises(TableError, match=words):
        read(path)


def test_a_run_that_is_there_twice_is_refused(tmp_path):
    path = write(tmp_path / "r.parquet", evaluation())
    table = pq.read_table(path)
    pq.write_table(pa.concat_tables([table, table]), path)
    with pytest.raises(TableError, match="holds a run twice"):
        read(path)


def test_a_full_disk_leaves_the_table_as_it_was(tmp_path):
    resource = pytest.importorskip("resource")
    path = write(tmp_path / "r.parquet", evaluation())
    before = path.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    with opened(path) as table:
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) // 2, limits[1]))
        try:
            with pytest.raises(OSError, match="File too large"):
                table.add([evaluation(of=run(1))])
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert len(table) == 1
        table.add([evaluation(of=run(2))])  # There is room again.
    assert [one.run.seed for one in read(path)] == [0, 2]
    assert [entry.name for entry in tmp_path.iterdir()] == ["r.parquet"]


def test_two_sweeps_never_write_to_one_table(tmp_path):
    pytest.importorskip("fcntl")
    path = tmp_path / "r.parquet"
    program = (
        "import sys, pathlib\nfrom ao2viz.experiments.table import opened\n"
        "with opened(pathlib.Path(sys.argv[1])):\n"
        "    print('open', flush=True)\n    sys.stdin.read()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"open\n"
        with pytest.raises(ValueError, match=r"Another sweep is writing to r\.parquet"):
            write(path, evaluation())
        other.kill()
    write(path, evaluation())  # A killed sweep leaves no lock behind.
    assert [entry.name for entry in tmp_path.iterdir()] == ["r.parquet"]

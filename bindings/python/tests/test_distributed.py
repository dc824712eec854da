"""Studies in parts on workers of Dask, of which one is killed."""

from __future__ import annotations

import os
import pickle
import signal
from pathlib import Path
from typing import Any, Iterator

import pytest

import palpate

dask = pytest.importorskip("distributed", reason="pip install palpate[distributed]")
parquet = pytest.importorskip("pyarrow.parquet", reason="pip install palpate[distributed]")

from palpate import distributed  # noqa: E402

pytestmark = [
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL here"),
]

FIG2 = "experiments/fig2.toml"


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """Three worker processes on this machine, each of one thread."""
    with dask.LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with dask.Client(cluster) as client:
            client.wait_for_workers(3)
            yield client


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def kill_one(client: Any, study: distributed.Study, folder: Path) -> int:
    """Kills a worker that is making a part, as soon as another part is there; the number of its worker process."""
    futures = study.submit(client, folder)
    next(iter(dask.as_completed(futures)))
    busy = {address for address, keys in client.processing().items() if keys}
    assert busy, "the study was over before a worker could be killed"
    victim = sorted(busy)[0]
    pids = client.run(os.getpid, workers=[victim])
    os.kill(pids[victim], signal.SIGKILL)
    client.gather(futures)
    return pids[victim]


def test_a_map_is_the_same_by_three_workers_of_which_one_is_killed(client: Any, program: Any, tmp_path: Path) -> None:
    study = distributed.map(["basic", "coupled"], cells=8, parts=16, delay_periods=0.5)
    pid = kill_one(client, study, tmp_path / "map")
    assert pid not in client.run(os.getpid).values()
    assert study.missing(tmp_path / "map") == []
    whole = palpate.map(["basic", "coupled"], cells=8, delay_periods=0.5)
    merged = study.merge(tmp_path / "map")
    assert merged.to_csv() == whole.to_csv() and merged.to_svg() == whole.to_svg()
    whole.pop("work")
    assert merged == whole
    # One process writes identical files.
    for part in range(1, 17):
        study.make(part, tmp_path)
    assert contents(tmp_path / "map") == contents(tmp_path)
    # A part has the same lines as a part of the program.
    program("map", "--cells", 8, "--method", "basic,coupled", "--delay-periods", 0.5, "--shard", "2/16", "--out", tmp_path / "part.csv")
    theirs = [line.split(",")[0] for line in (tmp_path / "part.csv").read_text().splitlines()[1:]]
    ours = parquet.read_table(tmp_path / study.file(2))
    assert [str(cell) for cell in ours["cell"].to_pylist()] == theirs and "growth_worst" in ours.column_names


def test_a_suite_in_parts_is_the_whole_one(client: Any, tmp_path: Path) -> None:
    for name, seed in (("paper", 3), ("desk", 1)):
        study = distributed.suite(name, ["hfcr", "coupled"], seed=seed, plants=7, parts=4)
        files = study.run(client, tmp_path / name)
        assert [path.name for path in files] == sorted(path.name for path in (tmp_path / name).iterdir())
        whole = palpate.suite(name, ["hfcr", "coupled"], seed=seed, plants=7)
        merged = study.merge(tmp_path / name)
        assert merged == whole and str(merged) == str(whole) and merged.to_svg() == whole.to_svg()


def test_scenes_are_tuned_each_as_a_task(client: Any, root: Path, tmp_path: Path) -> None:
    scenes = [palpate.Scene.read(FIG2).replace(loop={"period_s": period}) for period in (0.01, 0.005)]
    study = distributed.tune(scenes, "hfcr", steps=3)
    study.run(client, tmp_path)
    whole = [palpate.tune(scene, "hfcr", steps=3) for scene in scenes]
    merged = study.merge(tmp_path)
    assert merged == whole and merged[1].to_svg() == whole[1].to_svg()
    table = parquet.read_table(tmp_path / study.file(1))
    medians = [point.mean_force_error_percent.median for point in whole[0].curve]
    assert table["mean_force_error_percent_median"].to_pylist() == medians


def test_what_is_there_is_not_made_again(client: Any, tmp_path: Path) -> None:
    study = distributed.suite("paper", "basic", plants=3, parts=3)
    study.make(2, tmp_path)
    assert study.missing(tmp_path) == [1, 3]
    with pytest.raises(ValueError, match="2 of 3 parts are missing: 1, 3; run it again"):
        study.merge(tmp_path)
    before = (tmp_path / study.file(2)).stat()
    # Leftovers of a killed worker are harmless and are removed.
    (tmp_path / f".{study.file(1)}.torn").write_bytes(b"PAR1")
    assert len(study.submit(client, tmp_path)) == 2
    study.run(client, tmp_path)
    after = (tmp_path / study.file(2)).stat()
    assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)
    assert sorted(contents(tmp_path)) == [study.file(part) for part in (1, 2, 3)]
    again = pickle.loads(pickle.dumps(study))
    assert again.merge(tmp_path) == palpate.suite("paper", "basic", plants=3)


def test_parts_of_another_study_are_rejected(root: Path, tmp_path: Path) -> None:
    study = distributed.suite("paper", "basic", plants=3, parts=3)
    study.make(1, tmp_path)
    for other, key in [
        (distributed.suite("paper", "basic", plants=3, parts=3, seed=2), "its seed is 1, not 2"),
        (distributed.map("basic", cells=2, parts=3), "its study is 'suite', not 'map'"),
    ]:
        with pytest.raises(ValueError, match=f"is a part of another study: {key}"):
            other.missing(tmp_path)
    parquet.write_table(parquet.read_table(tmp_path / study.file(1)).replace_schema_metadata(), tmp_path / study.file(2))
    with pytest.raises(ValueError, match="is not a part of a study of palpate"):
        study.missing(tmp_path)
    for call, kind, said in [
        (lambda: study.make(4, tmp_path), ValueError, "part is 4, but must be 1 to 3"),
        (lambda: distributed.suite(parts=0), ValueError, "parts is 0, but must be 1 or more"),
        (lambda: distributed.suite(plants=3, parts=4), ValueError, "parts is 4, but there are 3 plants"),
        (lambda: distributed.suite(plants=10**12), ValueError, "plants is 1000000000000, but must be 1 to 1000000"),
        (lambda: distributed.map(cells=2, parts=7), ValueError, "parts is 7, but the map has 6 cells"),
        (lambda: distributed.map(cells=1), ValueError, "a map has 2 to 1000 cells along each axis, not 1"),
        (lambda: distributed.map(dealy=1), TypeError, "palpate.map has no argument dealy"),
        (lambda: distributed.suite("moon"), ValueError, 'set is "moon"'),
    ]:
        with pytest.raises(kind, match=said):
            call()

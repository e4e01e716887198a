"""Tasks over processes: all are done, whatever one of them does."""

import logging
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from distributed import Future, LocalCluster
from distributed.comm.core import CommClosedError

from xneck.batch import worker_pool as module
from xneck.batch.cluster import Cluster
from xneck.batch.worker_pool import TaskOutcome, run_tasks, worker_pool
from xneck_foundation.errors import Refused
from xneck_foundation.source_digest import source_digest


def square(x: int) -> int:
    return x * x


def troubled(x: int, folder: Path) -> int:
    """Fails in its own way: 0 refuses, 1 raises, 2 takes its worker along, 3 does so the first time."""
    if x == 0:
        raise Refused("here", "no such arm", "look again")
    if x == 1:
        np.linalg.inv(np.zeros((2, 2)))
    once = folder / "once"
    if x == 2 or (x == 3 and not once.exists()):
        once.touch() if x == 3 else None
        os.kill(os.getpid(), signal.SIGKILL)
    return x


def environment(*names: str) -> tuple[str | None, ...]:
    return tuple(os.environ.get(name) for name in names)


def sees_nothing(files: Sequence[tuple[str, int]]) -> tuple[str, dict[str, str], list[str]]:
    return source_digest(), {}, [path for path, _ in files]


def sees_only_tokens(files: Sequence[tuple[str, int]]) -> tuple[str, dict[str, str], list[str]]:
    return source_digest(), {}, [path for path, _ in files if ".seen-by-" not in path]


def other_numpy(_: Sequence[tuple[str, int]]) -> tuple[str, dict[str, str], list[str]]:
    return source_digest(), {"numpy": "1.0"}, []


def test_what_refuses_raises_or_kills_its_worker_is_told_and_the_others_go_on(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with worker_pool(2, None, tmp_path) as client:
        tasks = {f"task {i}": (i, tmp_path) for i in range(10)}
        outcomes = {o.name: o for o in run_tasks(client, troubled, tasks)}
        again = [
            *run_tasks(
                client, environment, {"a": ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MALLOC_TRIM_THRESHOLD_")}
            )
        ]
    assert set(outcomes) == set(tasks)
    assert {name: o.failure for name, o in outcomes.items() if o.failure} == {
        "task 0": "here: no such arm; look again",
        "task 1": "LinAlgError: Singular matrix",
        "task 2": "its worker died, 3 times",
    }
    assert [outcomes[f"task {i}"].result for i in range(3, 10)] == [*range(3, 10)]
    assert (tmp_path / "once").exists()
    assert again == [TaskOutcome("a", ("1", "1", None), None)]
    assert capfd.readouterr().err == ""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Of a cluster with one worker, in a process of its own."""
    options: Any = {"threads_per_worker": 1, "dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
    cluster: Any
    with LocalCluster(n_workers=1, **options) as cluster:
        yield cluster.scheduler_address


def test_a_cluster_that_is_there_is_used(address: str, tmp_path: Path) -> None:
    with worker_pool(None, Cluster(address), tmp_path) as client:
        outcomes = [*run_tasks(client, square, {str(i): (i,) for i in range(5)})]
    assert {o.name: o.result for o in outcomes} == {str(i): i * i for i in range(5)}
    assert not list(tmp_path.iterdir())


def test_a_cluster_that_would_fail_is_refused(address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refusal(*files: Path) -> str:
        with pytest.raises(Refused) as caught, worker_pool(None, Cluster(address), tmp_path, files):
            raise AssertionError("not refused")
        return str(caught.value)

    with monkeypatch.context() as patch:
        patch.setattr(module, "VERSION", "9.9")
        assert "has xneck " in refusal()
    with monkeypatch.context() as patch:
        patch.setattr(module, "source_digest", lambda: "others")
        assert "has other sources of xneck" in refusal()
    with monkeypatch.context() as patch:
        patch.setattr(module, "_worker_state", sees_nothing)
        assert f"does not see {tmp_path};" in refusal()
    with monkeypatch.context() as patch:
        patch.setattr(module, "_worker_state", other_numpy)
        assert "has numpy 1.0; install" in refusal()
    input_file = tmp_path / "video.mp4"
    input_file.write_bytes(b"1234")
    with worker_pool(None, Cluster(address), tmp_path, [input_file]) as client:
        assert client.submit(square, 3).result() == 9
    with monkeypatch.context() as patch:
        patch.setattr(module, "_worker_state", sees_only_tokens)
        assert f"does not see {input_file}" in refusal(input_file)


def test_files_of_another_size_are_not_seen(tmp_path: Path) -> None:
    (tmp_path / "log").write_bytes(b"1234")
    there, other, none = ((str(tmp_path / name), size) for name, size in (("log", 4), ("log", 5), ("none", 0)))
    assert module._worker_state([there])[2] == []
    assert module._worker_state([other, there, none])[2] == [other[0], none[0]]


def test_a_scheduler_that_is_lost_ends_it_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = (
        "from distributed import LocalCluster; import time\n"
        "with LocalCluster(n_workers=1, processes=False, dashboard_address='127.0.0.1:0', protocol='tcp') as c:\n"
        "    print(c.scheduler_address, flush=True); time.sleep(60)"
    )
    monkeypatch.setattr(module, "_CONNECT_TIMEOUT_S", 1)
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as elsewhere:
        assert elsewhere.stdout is not None
        scheduler = elsewhere.stdout.readline().strip()
        with worker_pool(None, Cluster(scheduler), tmp_path) as client:
            outcomes = run_tasks(client, square, {str(i): (i,) for i in range(9)})
            assert next(outcomes).failure is None
            elsewhere.kill()
            with pytest.raises(Refused, match="its scheduler is gone"):
                list(outcomes)


def test_workers_that_are_gone_for_good_end_it_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A task would wait for another one for ever."""
    monkeypatch.setattr(module, "_MAX_ALONE_S", 1.0)
    options: Any = {"processes": False, "dashboard_address": "127.0.0.1:0", "protocol": "tcp"}
    cluster: Any
    with (
        LocalCluster(n_workers=1, **options) as cluster,
        worker_pool(None, Cluster(cluster.scheduler_address), tmp_path) as client,
    ):
        outcomes = run_tasks(client, square, {str(i): (i,) for i in range(9)})
        assert next(outcomes).failure is None
        cluster.scale(0)
        with pytest.raises(Refused, match="the cluster: has had no workers for 1 s; start some"):
            list(outcomes)


@pytest.mark.parametrize("error", [CommClosedError("in <TCP (closed)>"), CancelledError("k")])
def test_a_scheduler_that_dies_before_a_result_is_fetched_ends_it_so_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def lost(_: Any) -> None:
        raise error

    with worker_pool(1, None, tmp_path) as client:
        monkeypatch.setattr(Future, "result", lost)
        with pytest.raises(Refused, match="its scheduler is gone"):
            list(run_tasks(client, square, {"1": (1,)}))


def test_no_cluster_and_one_without_workers_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    options: Any = {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
    idle: Any
    with (
        LocalCluster(n_workers=0, **options) as idle,
        pytest.raises(Refused, match="has no workers"),
        worker_pool(None, Cluster(idle.scheduler_address), tmp_path),
    ):
        pass
    monkeypatch.setattr(module, "_CONNECT_TIMEOUT_S", 0.5)
    with (
        pytest.raises(Refused, match="no dask scheduler answers there"),
        worker_pool(None, Cluster("tcp://127.0.0.1:1"), tmp_path),
    ):
        pass

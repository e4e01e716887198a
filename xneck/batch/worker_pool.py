"""Many tasks on many cores or machines by dask.distributed: each worker runs one at a time, and one that fails stops no other."""

import logging
import math
import sys
import tempfile
import time
import uuid
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from xneck.batch.cluster import LOCAL_SETTINGS, Cluster, own_security
from xneck_foundation.errors import Refused
from xneck_foundation.provenance import versions
from xneck_foundation.source_digest import source_digest
from xneck_foundation.version import VERSION
from xneck_foundation.whole_file import replaces_any_file, replacing_any_file

if TYPE_CHECKING:
    from distributed import Client

Result = TypeVar("Result")

_MAX_WORKER_DEATHS = 2
"""workers that may die under a task before it is given up: the third death is the task's fault, no accident (docs/thresholds.md)"""
_POLL_S = 1.0
"""s: time after which it is seen that there are more workers, or fewer"""
_MAX_ALONE_S = 60.0
"""s: a cluster whose workers are all gone for longer is refused; those that are started anew come back within it
(docs/thresholds.md)"""
_CONNECT_TIMEOUT_S = 10
"""s: a scheduler that does not answer within it is refused (docs/thresholds.md)"""
_DASK_SETTINGS: dict[str, Any] = {
    # the scheduler would start a task again on a worker that is at work, and blame both for the next death
    "distributed.scheduler.allowed-failures": 0,
    # replaces dask's own settings, by which malloc returns freed pages at once: numpy then spent 2 of 5 s on new ones
    "distributed.nanny.pre-spawn-environ": dict.fromkeys(
        ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), 1
    ),
}
_LOCAL_CLUSTER: dict[str, Any] = {
    "threads_per_worker": 1,
    "host": "127.0.0.1",
    "silence_logs": logging.CRITICAL,
    # without an address the scheduler would take port 8787, which another cluster of this machine may hold
    "dashboard_address": "127.0.0.1:0",
    "scheduler_kwargs": {"dashboard": False},
}


@dataclass(frozen=True)
class TaskOutcome(Generic[Result]):
    """What became of a task: its result, or why there is none."""

    name: str
    result: Result | None
    failure: str | None
    """one line, or None where it did not fail"""


@contextmanager
def worker_pool(
    jobs: int | None, cluster: Cluster | None, folder: Path, files: Sequence[Path] = ()
) -> "Iterator[Client]":
    """A client of `jobs` local processes of one thread each (None: one a core), or of a `cluster`.

    Local processes listen on this machine alone, and only to those who have a certificate that is made for them.

    Raises Refused where a cluster cannot be reached, has no workers, has another Python, xneck or libraries, or does not
    see `folder` and `files`.
    """
    import dask.config
    from distributed import Client, LocalCluster

    # what ends without a result is said by `spread`, once
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if cluster is None:
        with (
            dask.config.set(_DASK_SETTINGS | LOCAL_SETTINGS),
            LocalCluster(
                n_workers=jobs or available_cores(), security=own_security(), **_LOCAL_CLUSTER
            ) as local_cluster,
            Client(local_cluster) as client,
        ):
            yield client
        return
    try:
        client = Client(cluster.address, timeout=_CONNECT_TIMEOUT_S, security=cluster.security())
    except (OSError, ValueError) as error:
        what = "no dask scheduler answers there" + (" that accepts these certificates" if cluster.ca_file else "")
        raise Refused(cluster.address, what, "give its address, as tls://host:8786") from error
    with client:
        _preflight(client, cluster.address, folder, files)
        yield client


def run_tasks(
    client: "Client", function: Callable[..., Result], tasks: Mapping[str, tuple[Any, ...]]
) -> "Iterator[TaskOutcome[Result]]":
    """Calls function(*arguments) for each task, by name, on the workers, which import `function`; yields each as it ends.

    A task whose worker dies is started again; one that raises is not, as it would raise again.
    Raises Refused where the scheduler is lost, or all workers are, for good.
    """
    from distributed import wait

    pending = deque(tasks)
    running: dict[Any, str] = {}
    deaths: Counter[str] = Counter()
    alone_since = math.inf
    while pending or running:
        threads = _thread_count(client)
        alone_since = math.inf if threads else min(alone_since, time.monotonic())
        if time.monotonic() - alone_since > _MAX_ALONE_S:
            what = f"has had no workers for {_MAX_ALONE_S:g} s"
            raise Refused("the cluster", what, "start some, then the same command again")
        # no more than can run: a task that waits on a worker that dies is blamed with the one that killed it
        while pending and len(running) < max(1, threads):
            name = pending.popleft()
            key = f"{name}-{uuid.uuid4().hex}"
            running[client.submit(_result_or_refusal, function, tasks[name], replaces_any_file(), key=key)] = name
        # workers that died come back while others are at work: looked for now and then
        with suppress(TimeoutError, CancelledError):
            wait([*running], timeout=_POLL_S, return_when="FIRST_COMPLETED")
        for future in [future for future in running if future.done()]:
            name = running.pop(future)
            if future.status == "finished":
                with _scheduler_there():
                    result, refusal = future.result()
                yield TaskOutcome(name, result, refusal)
                continue
            with _scheduler_there():
                deaths[name] += _worker_deaths(future)
            if 0 < deaths[name] <= _MAX_WORKER_DEATHS:
                pending.append(name)
            else:
                yield TaskOutcome(name, None, _failure(future, deaths[name]))


def _worker_deaths(future: Any) -> int:
    """Number of workers that died under a task that ended without a result; 0 where it ended otherwise."""
    from distributed import KilledWorker

    error = None if future.cancelled() else future.exception()
    return error.allowed_failures + 1 if isinstance(error, KilledWorker) else 0


def _thread_count(client: Any) -> int:
    """Threads of all workers that are connected."""
    with _scheduler_there():
        return sum(client.nthreads().values())


@contextmanager
def _scheduler_there() -> Iterator[None]:
    """Around what is asked of the scheduler, which may die between any two questions.

    Raises Refused where it is gone; an OSError of a task is its result, and none of these.
    """
    try:
        yield
    except (OSError, CancelledError) as error:
        raise Refused("the cluster", "its scheduler is gone", "start it, then the same command again") from error


def _result_or_refusal(
    function: Callable[..., Result], arguments: tuple[Any, ...], replace_any: bool
) -> tuple[Result | None, str | None]:
    """Runs on the worker: the result, or the line of a refusal; `replace_any`: whether it may replace files not of xneck's."""
    try:
        with replacing_any_file() if replace_any else nullcontext():
            return function(*arguments), None
    except Refused as refusal:
        return None, str(refusal)


def _failure(future: Any, deaths: int) -> str:
    """One line that says why a task ended without a result, after so many `deaths` of its workers."""
    if future.cancelled():
        return "the cluster was lost"
    if deaths:
        return f"its worker died, {deaths} times"
    error = future.exception()
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def available_cores() -> int:
    """Number of cores that this process may use."""
    from dask.system import CPU_COUNT

    return CPU_COUNT


def _preflight(client: Any, cluster: str, folder: Path, files: Sequence[Path]) -> None:
    """Raises Refused where the workers lack this xneck, this Python, these libraries or the files."""
    from distributed import TimeoutError as ClusterTimeout

    try:
        reported = client.get_versions(packages=["xneck"])
    except (OSError, ClusterTimeout) as error:
        raise Refused(cluster, "does not answer") from error
    if not reported["workers"]:
        raise Refused(cluster, "has no workers", f"start some: dask worker {cluster}")
    python = ".".join(map(str, sys.version_info[:2]))
    for process, software in {"its scheduler": reported["scheduler"], **reported["workers"]}.items():
        version = software["packages"].get("xneck")
        if version != VERSION:
            what = f"{process} has {f'xneck {version}' if version else 'no xneck'}"
            raise Refused(cluster, what, f"install {VERSION} there")
        if not software["host"]["python"].startswith(f"{python}."):
            raise Refused(cluster, f"{process} runs Python {software['host']['python']}", f"run it with {python}")
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".seen-by-") as token:
        sizes = [(str(path), path.stat().st_size) for path in files]
        for worker, (source, libraries, missing) in client.run(_worker_state, [(token.name, 0), *sizes]).items():
            if source != source_digest():
                raise Refused(cluster, f"{worker} has other sources of xneck", "install the same there")
            for name, version in libraries.items():
                if (ours := versions()["libraries"][name]) != version:
                    raise Refused(cluster, f"{worker} has {name} {version}", f"install {ours} there, as here")
            if missing:
                what = f"{worker} does not see {folder if token.name in missing else missing[0]}"
                raise Refused(cluster, what, "put it where all machines see it by the same path")


def _worker_state(files: Sequence[tuple[str, int]]) -> tuple[str, dict[str, str], list[str]]:
    """Runs on a worker: its digest of the sources, its libraries, and those of `files` (name, bytes) that it does not see so."""
    missing = [path for path, size in files if not Path(path).is_file() or Path(path).stat().st_size != size]
    return source_digest(), versions()["libraries"], missing

"""Many tasks over many cores or machines by dask.distributed: one after the other on each, none lost with the one that fails."""

import logging
import sys
import tempfile
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import xneck
from xneck_foundation.errors import Refused
from xneck_foundation.provenance import versions
from xneck_foundation.source_digest import digest

if TYPE_CHECKING:
    from distributed import Client

T = TypeVar("T")

_DEATHS = 2
"""of workers that a task may outlive: what kills three was no accident of theirs"""
_CONNECT_S = 10
_SETTINGS: dict[str, Any] = {
    "distributed.scheduler.allowed-failures": _DEATHS,
    # dask also has malloc give back what is freed at once: the pages that numpy then asks for anew took 2 of 5 s
    "distributed.nanny.pre-spawn-environ": dict.fromkeys(
        ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"), 1
    ),
}
_LOCAL: dict[str, Any] = {
    "threads_per_worker": 1,
    "silence_logs": logging.CRITICAL,
    # without an address the scheduler takes port 8787, of this machine's other clusters too
    "dashboard_address": "127.0.0.1:0",
    "scheduler_kwargs": {"dashboard": False},
}


@dataclass(frozen=True)
class Outcome(Generic[T]):
    """What became of a task: its result, or why there is none."""

    name: str
    result: T | None
    failure: str | None
    """one line, or None where it did not fail"""


@contextmanager
def workers(jobs: int | None, cluster: str | None, folder: Path, files: Sequence[Path] = ()) -> "Iterator[Client]":
    """A client of `jobs` local processes of one thread each (None: one a core), or of the scheduler at the address `cluster`.

    Raises Refused where a cluster cannot be reached, has no workers, has another Python, xneck or libraries, or does not
    see `folder` and `files`.
    """
    import dask.config
    from distributed import Client, LocalCluster

    # what ends without a result is said by `spread`, once
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if cluster is None:
        with (
            dask.config.set(_SETTINGS),
            LocalCluster(n_workers=jobs or cores(), **_LOCAL) as local,
            Client(local) as client,
        ):
            yield client
        return
    try:
        client = Client(cluster, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        raise Refused(cluster, "no dask scheduler answers there", "give its address, as tcp://host:8786") from error
    with client:
        _preflight(client, cluster, folder, files)
        yield client


def spread(
    client: "Client", function: Callable[..., T], tasks: Mapping[str, tuple[Any, ...]]
) -> "Iterator[Outcome[T]]":
    """function(*arguments) for each named task, as they end; `function` is found by its import path on the workers.

    As many run as there are threads. One whose worker dies is begun again on others; one that raises is not, as it would again.
    Raises Refused where the scheduler is lost.
    """
    from distributed import as_completed

    waiting = iter(tasks.items())
    running: dict[Any, str] = {}
    ended = as_completed()

    def begin() -> None:
        # no more than can run: what waits on a worker that dies would be blamed with the one that killed it
        threads = _threads(client)
        while len(running) < threads:
            name, arguments = next(waiting, (None, ()))
            if name is None:
                return
            future = client.submit(_tried, function, arguments, key=f"{name}-{uuid.uuid4().hex}")
            running[future] = name
            ended.add(future)

    begin()
    for future in ended:
        name = running.pop(future)
        if future.status == "finished":
            result, refusal = future.result()
            yield Outcome(name, result, refusal)
        else:
            yield Outcome(name, None, _why(future))
        begin()


def _threads(client: Any) -> int:
    """That work now, or one, to wait for."""
    try:
        return max(1, sum(client.nthreads().values()))
    except OSError as error:
        raise Refused("the cluster", "its scheduler is gone", "start it, then the same command again") from error


def _tried(function: Callable[..., T], arguments: tuple[Any, ...]) -> tuple[T | None, str | None]:
    """On the worker: the result, or the line of a refusal."""
    try:
        return function(*arguments), None
    except Refused as refusal:
        return None, str(refusal)


def _why(future: Any) -> str:
    """One line about a task that ended without a result."""
    from distributed import KilledWorker

    if future.cancelled():
        return "the cluster was lost"
    error = future.exception()
    if isinstance(error, KilledWorker):
        return f"its worker died, {error.allowed_failures + 1} times"
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def cores() -> int:
    """That this process may use."""
    from dask.system import CPU_COUNT

    return CPU_COUNT


def _preflight(client: Any, cluster: str, folder: Path, files: Sequence[Path]) -> None:
    """Refused where tasks would fail, or hang, for want of the package, of the same one, or of the files."""
    from distributed import TimeoutError as TooLate

    try:
        told = client.get_versions(packages=["xneck"])
    except (OSError, TooLate) as error:
        raise Refused(cluster, "does not answer") from error
    if not told["workers"]:
        raise Refused(cluster, "has no workers", f"start some: dask worker {cluster}")
    python = ".".join(map(str, sys.version_info[:2]))
    for who, one in {"its scheduler": told["scheduler"], **told["workers"]}.items():
        found = one["packages"].get("xneck")
        if found != xneck.__version__:
            raise Refused(
                cluster, f"{who} has {f'xneck {found}' if found else 'no xneck'}", f"install {xneck.__version__} there"
            )
        if not one["host"]["python"].startswith(f"{python}."):
            raise Refused(cluster, f"{who} runs Python {one['host']['python']}", f"run it with {python}")
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".seen-by-") as token:
        there = [(str(path), path.stat().st_size) for path in files]
        for who, (source, libraries, missing) in client.run(_at_home, [(token.name, 0), *there]).items():
            if source != digest():
                raise Refused(cluster, f"{who} has other sources of xneck", "install the same there")
            for name, found in libraries.items():
                if (ours := versions()["libraries"][name]) != found:
                    raise Refused(cluster, f"{who} has {name} {found}", f"install {ours} there, as here")
            if missing:
                what = folder if token.name in missing else missing[0]
                raise Refused(
                    cluster, f"{who} does not see {what}", "put it where all machines see it by the same path"
                )


def _at_home(files: Sequence[tuple[str, int]]) -> tuple[str, dict[str, str], list[str]]:
    """On a worker: what it would compute with, and which files it does not see, or sees with another size."""
    missing = [path for path, size in files if not Path(path).is_file() or Path(path).stat().st_size != size]
    return digest(), versions()["libraries"], missing

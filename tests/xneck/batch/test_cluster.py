"""Nobody takes part in a run who has no certificate for it."""

import asyncio
import logging
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
from distributed import Client, LocalCluster
from distributed.comm.core import connect
from distributed.security import Security

from tests.command import run
from xneck.batch import worker_pool as module
from xneck.batch.cluster import Cluster
from xneck.batch.worker_pool import TaskOutcome, run_tasks, worker_pool
from xneck_foundation.errors import Refused


def square(x: int) -> int:
    return x * x


def listening() -> list[Any]:
    """Addresses at which this process and those that it started wait for others."""
    here = psutil.Process()
    sockets = [c for p in (here, *here.children(recursive=True)) for c in p.net_connections(kind="inet")]
    return [c.laddr for c in sockets if c.status == psutil.CONN_LISTEN]


def answers(address: str, security: Security) -> bool:
    """Whether a member at this address speaks with somebody who has these certificates."""

    async def greeting() -> bool:
        comm = await connect(address, timeout=2, **security.get_connection_args("client"))
        try:
            await comm.write({"op": "identity", "reply": True})
            return "type" in await comm.read()
        finally:
            comm.abort()

    try:
        return asyncio.run(greeting())
    except (OSError, ValueError):
        return False


def test_a_run_on_this_machine_lets_nobody_in(tmp_path: Path) -> None:
    """Neither without a certificate nor with another one, at none of its processes; the run itself works meanwhile."""
    already = set(listening())
    with worker_pool(1, None, tmp_path) as client:
        places = [one for one in listening() if one not in already]
        assert {one.ip for one in places} == {"127.0.0.1"}
        info = client.scheduler_info()
        members = [info["address"], *info["workers"], *(worker["nanny"] for worker in info["workers"].values())]
        assert len(members) == 3
        for member in members:
            assert member.startswith("tls://127.0.0.1:")
            assert answers(member, client.security)
            assert not answers(member, Security.temporary())
            assert not answers(member.replace("tls://", "tcp://"), Security())
        with pytest.raises(OSError, match=r"tcp://127\.0\.0\.1"):
            Client(info["address"].replace("tls://", "tcp://"), timeout=1)
        web = {one.port for one in places} - {int(member.rpartition(":")[2]) for member in members}
        for port in web:
            for page in ("health", "metrics", "info/main/workers.html"):
                with pytest.raises(urllib.error.HTTPError, match="404"):
                    urllib.request.urlopen(f"http://127.0.0.1:{port}/{page}", timeout=5)
        assert [*run_tasks(client, square, {"a": (3,)})] == [TaskOutcome("a", 9, None)]


def written(security: Security, folder: Path) -> dict[str, Path]:
    """The certificates as files."""
    folder.mkdir()
    parts = {"ca_file": security.tls_ca_file, "certificate": security.tls_client_cert, "key": security.tls_client_key}
    for name, text in parts.items():
        (folder / name).write_text(text)
    return {name: folder / name for name in parts}


@pytest.fixture(scope="module")
def encrypted(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, dict[str, Path]]]:
    """A cluster with certificates: its address, and their files."""
    security = Security.temporary()
    # in this process: a nanny would leave dask's settings of malloc in its environment
    options: Any = {"processes": False, "protocol": "tls://", "threads_per_worker": 1}
    options |= {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL}
    cluster: Any
    with LocalCluster(n_workers=1, security=security, **options) as cluster:
        yield cluster.scheduler_address, written(security, tmp_path_factory.mktemp("tls") / "ours")


def test_a_cluster_with_certificates_is_used(encrypted: tuple[str, dict[str, Path]], tmp_path: Path) -> None:
    address, files = encrypted
    with worker_pool(None, Cluster(address, **files), tmp_path) as client:
        assert [*run_tasks(client, square, {"a": (3,)})] == [TaskOutcome("a", 9, None)]


def test_it_is_not_used_with_others(
    encrypted: tuple[str, dict[str, Path]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    address, files = encrypted
    monkeypatch.setattr(module, "_CONNECT_TIMEOUT_S", 1)

    def refusal(cluster: Cluster) -> str:
        with pytest.raises(Refused) as caught, worker_pool(None, cluster, tmp_path):
            raise AssertionError("not refused")
        return str(caught.value)

    others = written(Security.temporary(), tmp_path / "others")
    assert "no dask scheduler answers there that accepts these certificates" in refusal(Cluster(address, **others))
    assert "needs certificates; give --tls-ca-file" in refusal(Cluster(address))
    plain = address.replace("tls://", "tcp://")
    assert "no dask scheduler answers there" in refusal(Cluster(plain))
    assert "has no use for certificates; give its address as tls://" in refusal(Cluster(plain, **files))
    (tmp_path / "text").write_text("no certificate")
    said = refusal(Cluster(address, tmp_path / "text", files["certificate"], files["key"]))
    assert "no usable certificates in text, certificate, key (" in said


@pytest.mark.parametrize(
    "words",
    [
        ("--tls-ca-file", "ca.pem"),
        ("--cluster", "tls://x:1", "--tls-ca-file", "ca.pem"),
        ("--cluster", "tls://x:1", "--tls-cert", "cert.pem"),
        ("--cluster", "tls://x:1", "--tls-key", "key.pem"),
    ],
)
@pytest.mark.parametrize("command", ["run", "study"])
def test_certificates_that_are_not_complete_are_wrong_usage(
    command: str, words: tuple[str, ...], capfd: pytest.CaptureFixture[str]
) -> None:
    ran = run(capfd, command, *(["x"] if command == "run" else []), *words)
    assert ran.status == 2
    assert "--tls-ca-file" in ran.err

"""Options of the commands that spread their work: over this machine, or over a dask cluster."""

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from xneck.cli.path_types import INPUT_FILE

Command = TypeVar("Command", bound=Callable[..., Any])

_OPTIONS = (
    click.option("--jobs", type=click.IntRange(1, 1024), help="Processes on this machine.  [default: one a core]"),
    click.option(
        "--cluster", "address", metavar="ADDRESS", help="A dask scheduler instead, such as tls://host:8786."
    ),
    click.option(
        "--tls-ca-file", "ca_file", type=INPUT_FILE, help="The authority of the cluster's certificates (PEM)."
    ),
    click.option("--tls-cert", "certificate", type=INPUT_FILE, help="Our certificate for the cluster (PEM)."),
    click.option("--tls-key", "key", type=INPUT_FILE, help="Its key, where it is not in the same file (PEM)."),
)  # fmt: skip
"""named as `dask scheduler` and `dask worker` name theirs"""


def worker_options(function: Command) -> Command:
    """Adds --jobs, --cluster and its certificates to a command, which is called with `jobs` and `cluster`; one of them is None."""

    @functools.wraps(function)
    def checked(
        *values: Any,
        jobs: int | None,
        address: str | None,
        ca_file: Path | None,
        certificate: Path | None,
        key: Path | None,
        **options: Any,
    ) -> Any:
        if jobs and address:
            raise click.UsageError("--jobs is for this machine; a --cluster has its own number of workers")
        if address is None and (ca_file or certificate or key):
            raise click.UsageError("--tls-ca-file, --tls-cert and --tls-key are for a --cluster")
        if (ca_file is None) != (certificate is None) or (key and not certificate):
            raise click.UsageError("--tls-ca-file and --tls-cert go together")
        from xneck.batch.cluster import Cluster

        cluster = None if address is None else Cluster(address, ca_file, certificate, key)
        return function(*values, jobs=jobs, cluster=cluster, **options)

    for option in reversed(_OPTIONS):
        checked = option(checked)
    return checked  # type: ignore[return-value]

"""Who takes part in a cluster: its members run any code that another sends them, so they must be told apart."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from xneck_foundation.errors import Refused

if TYPE_CHECKING:
    from distributed.security import Security

_TLS = "tls://"

LOCAL_SETTINGS: dict[str, Any] = {
    # pages about tasks and their logs, which need no certificate
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.nanny.http.routes": [],
}
"""dask's settings of a cluster on this machine"""


@dataclass(frozen=True)
class Cluster:
    """A dask scheduler, and the certificates by which it and its workers know us and we know them."""

    address: str
    """such as tls://host:8786; tcp://host:8786 where everybody who reaches it may run code on it"""
    ca_file: Path | None = None
    """PEM file of the authority whose certificates we believe"""
    certificate: Path | None = None
    """PEM file of our own certificate"""
    key: Path | None = None
    """PEM file of our key; None where it stands in the certificate's file"""

    def security(self) -> "Security":
        """dask's form of the certificates, or those of dask's own configuration where none are given.

        Raises Refused where they do not fit the address, or cannot be read.
        """
        from distributed.security import Security

        given = {"tls_ca_file": self.ca_file, "tls_client_cert": self.certificate, "tls_client_key": self.key}
        files = {name: str(path) for name, path in given.items() if path is not None}
        encrypted = self.address.startswith(_TLS)
        if files and not encrypted:
            raise Refused(self.address, "has no use for certificates", f"give its address as {_TLS}host:8786")
        security = Security(require_encryption=encrypted or None, **files)
        if encrypted and not (security.tls_ca_file and security.tls_client_cert):
            raise Refused(self.address, "needs certificates", "give --tls-ca-file, --tls-cert and --tls-key")
        try:
            security.get_connection_args("client")
        except OSError as error:  # of ssl too
            names = ", ".join(path.name for path in given.values() if path is not None) or "dask's configuration"
            what = f"no usable certificates in {names} ({error.strerror or error})"
            raise Refused(self.address, what, "give PEM files that belong together") from error
        return security


def own_security() -> "Security":
    """A key and a certificate that nobody else has, for a cluster on this machine: other users of it are kept out."""
    from distributed.security import Security

    return Security.temporary()

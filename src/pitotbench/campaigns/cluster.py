"""A fleet on the workers of a dask scheduler, of the same code and versions as the driver."""

import platform
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pitotbench.records import BadInputError
from pitotbench.records.intake import read_toml

_ALIKE = ("pitotbench", "jsbsim", "numpy", "scipy")  # their versions can change a result
_PATIENCE = 60.0  # s to wait for the first worker


@dataclass(frozen=True, slots=True)
class Host:
    """The versions of a process that is to fly for a campaign, and the digest of its code."""

    versions: Mapping[str, str]
    code: str


def describe_host() -> Host:
    """Return the versions and the code of this process."""
    from pitotbench.campaigns.digests import code_digest

    versions = {"python": platform.python_version()} | {name: version(name) for name in _ALIKE}
    return Host(versions, code_digest())


@contextmanager
def open_cluster(address: str, security: Path | None = None) -> Iterator[tuple[Executor, int]]:
    """Give the executor of a dask scheduler and the number of its workers.

    Every worker must have the versions and the code of the driver, and one thread: this is checked
    before anything is flown.

    Raises BadInputError where dask is not installed, where the scheduler does not answer, where it
    has no worker within a minute, and where a worker has other versions, other code or more than
    one thread.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError as error:
        raise BadInputError("--scheduler needs dask: pip install 'pitotbench[cluster]'") from error
    secured = _security(distributed, address, security)
    try:
        client = distributed.Client(address, timeout="10s", security=secured)
    except (OSError, ValueError, RuntimeError) as error:
        raise BadInputError(f"no dask scheduler answers at {address}: {error}") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError as error:
            raise BadInputError(
                f"the scheduler at {address} has no worker; start one with `dask worker`"
            ) from error
        workers = client.scheduler_info(n_workers=-1)["workers"]
        _require_one_thread(workers)
        check_hosts(describe_host(), client.run(describe_host, on_error="return"))
        yield client.get_executor(pure=False), len(workers)


def check_hosts(here: Host, workers: Mapping[str, Host | Exception]) -> None:
    """Raise BadInputError for a worker that differs in a version or in the code.

    The message names the worker and the first difference.
    """
    for name, there in workers.items():
        if isinstance(there, BaseException):
            raise BadInputError(f"worker {name} cannot fly: {type(there).__name__}: {there}")
        for what, mine in here.versions.items():
            if there.versions.get(what) != mine:
                raise BadInputError(
                    f"worker {name} has {what} {there.versions.get(what)}, the driver has {mine}"
                )
        if there.code != here.code:
            raise BadInputError(
                f"worker {name} has other code or aircraft files than the driver; install the same"
            )


def _require_one_thread(workers: Mapping[str, Mapping[str, Any]]) -> None:
    for name, worker in workers.items():
        if worker["nthreads"] != 1:
            raise BadInputError(
                f"worker {name} has {worker['nthreads']} threads; a flight needs a process: "
                "start it with `dask worker --nthreads 1 --nworkers N`"
            )


def _security(distributed: Any, address: str, file: Path | None) -> Any:
    """Return dask's own record of the certificates that a TOML file names.

    A `tls://` scheduler asks for them.
    """
    if file is None:
        if address.startswith("tls"):
            raise BadInputError(
                f"{address} asks for certificates: give --security FILE with the paths ca, cert "
                "and key"
            )
        return None
    stated = read_toml(file, "the paths of certificates")
    try:
        ca, cert, key = (str(file.parent / stated[name]) for name in ("ca", "cert", "key"))
        security = distributed.Security(
            tls_ca_file=ca,
            tls_client_cert=cert,
            tls_client_key=key,
            require_encryption=address.startswith("tls"),
        )
        security.get_connection_args("client")  # reads the files
    except (OSError, ValueError, KeyError, TypeError) as error:
        why = f": {error.strerror}" if isinstance(error, OSError) and error.strerror else ""
        raise BadInputError(
            f"{file}: not a TOML file with the paths ca, cert and key of readable files{why}"
        ) from error
    return security

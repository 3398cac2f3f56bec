"""A campaign on a cluster that asks for certificates, with and without the file that names them."""

import subprocess
from collections.abc import Iterator
from pathlib import Path

from pitotbench.evidence.campaigns.drivers import dask_cluster, fly_campaign, parts, write_plan_file


def fly_secured(folder: Path, flights: int) -> Iterator[str]:
    """Fly on a `tls://` cluster with the security file, with that of another authority, and without one."""
    plan = write_plan_file(folder, str(flights))
    ours, theirs = _certificates(folder / "ours"), _certificates(folder / "theirs")
    flags = [f"--tls-{kind}={ours.parent / name}" for kind, name in (("ca-file", "ca.pem"), *_PAIR)]
    with dask_cluster(flags=flags) as cluster:
        for what, security in (("with its file", ours), ("with another's", theirs), ("without", None)):
            more = () if security is None else ("--security", str(security))
            ended = fly_campaign(plan, folder / "out", "--scheduler", cluster.address, *more)
            yield f"tls {what}: exit code {ended.code}, {parts(folder / 'out')} stored: {ended.said[:150]}"


_PAIR = (("cert", "cert.pem"), ("key", "key.pem"))


def _certificates(folder: Path) -> Path:
    """Make an authority and a certificate of it with openssl; return the security file that names them."""
    folder.mkdir(parents=True)
    new = ("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=pitotbench")
    # One certificate that signs itself is the authority and the identity of every process.
    _openssl(*new, "-keyout", str(folder / "key.pem"), "-out", str(folder / "cert.pem"))
    (folder / "ca.pem").write_bytes((folder / "cert.pem").read_bytes())
    file = folder / "tls.toml"
    file.write_text('ca = "ca.pem"\ncert = "cert.pem"\nkey = "key.pem"\n')
    return file


def _openssl(*arguments: str) -> None:
    subprocess.run(["openssl", *arguments], check=True, capture_output=True)

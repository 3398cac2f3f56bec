"""A worker of a cluster that differs from the driver is refused by name, before anything is flown."""

from dataclasses import replace

import pytest

from pitotbench.bench.fleet import Host, Limits, check_hosts, open_cluster
from pitotbench.records import BadInputError

HERE = Host({"python": "3.11.7", "jsbsim": "1.3.3"}, "c0de")


def test_workers_that_are_like_the_driver_pass():
    check_hosts(HERE, {"a": HERE, "b": replace(HERE)})


@pytest.mark.parametrize(
    ("worker", "says"),
    [
        (replace(HERE, versions={"python": "3.11.7", "jsbsim": "1.2.0"}), "jsbsim 1.2.0, the driver has 1.3.3"),
        (replace(HERE, code="other"), "worker b has other code"),
        (ModuleNotFoundError("No module named 'pitotbench'"), "worker b cannot fly: ModuleNotFoundError"),
    ],
)  # fmt: skip
def test_a_worker_that_differs_is_refused_by_name(worker, says):
    with pytest.raises(BadInputError, match=says):
        check_hosts(HERE, {"a": HERE, "b": worker})


def test_a_scheduler_with_certificates_asks_for_the_security_file():
    pytest.importorskip("distributed", reason="dask.distributed is an extra")
    says = "asks for certificates: give --security FILE"
    with pytest.raises(BadInputError, match=says), open_cluster("tls://127.0.0.1:1", Limits()):
        pass


def test_a_wrong_security_file_is_refused_by_name(tmp_path):
    pytest.importorskip("distributed", reason="dask.distributed is an extra")
    file = tmp_path / "tls.toml"
    for text, says in (("ca = 1", "paths ca, cert and key"), ('ca = "a"\ncert = "b"\nkey = "c"', "No such file")):
        file.write_text(text)
        with pytest.raises(BadInputError, match=says), open_cluster("tls://127.0.0.1:1", Limits(), file):
            pass

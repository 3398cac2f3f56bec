"""Whether NumPy and OpenBLAS took the processor asked for: they pass over names that they do not
know.

Run by `make test-processors`, which sets the variables; pytest does not collect this file by
itself.
"""

import os

import numpy as np
from threadpoolctl import threadpool_info

FEATURES = np._core._multiarray_umath.__cpu_features__
ABOVE_THE_BASELINE = {
    "AVX",
    "AVX2",
    "FMA3",
    "X86_V3",
    "X86_V4",
    "AVX512F",
    "AVX512_SKX",
    "AVX512_ICL",
    "AVX512_SPR",
}


WITHOUT_AVX = {
    "Prescott",
    "Katmai",
}  # the kernels of Prescott go by the older name where a build has but one set


def test_openblas_runs_the_kernels_asked_for():
    found = {
        library["architecture"]
        for library in threadpool_info()
        if library["internal_api"] == "openblas"
    }
    assert found
    assert os.environ.get("OPENBLAS_CORETYPE") != "Prescott" or found <= WITHOUT_AVX


def test_numpy_dispatches_to_no_feature_that_was_disabled():
    """A level such as X86_V3 switches off the code for AVX2 and FMA3, not the knowledge that they
    are there.
    """
    dispatched = ABOVE_THE_BASELINE.intersection(np._core._multiarray_umath.__cpu_dispatch__)
    disabled = set(os.environ.get("NPY_DISABLE_CPU_FEATURES", "").split())
    assert not disabled or not [name for name in sorted(dispatched) if FEATURES[name]]

"""What is measured of each benchmark."""

import time
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

#: seconds that a round of short calls takes at least
ROUND = 2e-3


@pytest.fixture(autouse=True)
def one_thread():
    """One thread in all linear algebra, as in all timings of the project."""
    with threadpool_limits(1):
        yield


@pytest.fixture
def measure(benchmark):
    """Time a function: wall and processor time of a call, and the memory of its NumPy arrays."""

    def run(function: Callable[[], object], *, rounds: int = 15, **labels: object) -> None:
        function()  # compiled from here on
        begin = time.perf_counter()
        function()
        once = time.perf_counter() - begin
        tracemalloc.start()
        function()
        memory = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        calls = max(1, round(ROUND / once))
        processor = []

        def repeated() -> None:
            begun = time.process_time()
            for _ in range(calls):
                function()
            processor.append((time.process_time() - begun) / calls)

        benchmark.pedantic(repeated, rounds=rounds)
        wall = np.array(benchmark.stats.stats.data) / calls
        quarter, median, three_quarters = np.quantile(processor, [0.25, 0.5, 0.75])
        benchmark.extra_info.update(
            labels,
            wall_s=float(np.median(wall)),
            processor_s=float(median),
            spread=float((three_quarters - quarter) / median),
            memory_bytes=memory,
        )

    return run


@pytest.fixture
def measure_once(benchmark):
    """Time a function that runs for seconds: once, compiled or not."""

    def run(function: Callable[[], object], **labels: object) -> object:
        processor = time.process_time()
        found = benchmark.pedantic(function, rounds=1)
        benchmark.extra_info.update(
            labels,
            wall_s=benchmark.stats.stats.data[0],
            processor_s=time.process_time() - processor,
        )
        return found

    return run

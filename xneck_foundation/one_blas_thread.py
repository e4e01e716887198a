"""One thread of linear algebra: sums over several threads end in other last digits, so results would depend on the number of cores.

More threads would not be faster either: our matrices are small, and who has many recordings gives each a process.
"""

import functools
import threading
from collections.abc import Callable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

_ONE_AT_A_TIME = threading.RLock()
"""the number of threads belongs to the process: who returns first would give them back to who still computes"""


def one_blas_thread(function: Callable[P, R]) -> Callable[P, R]:
    """`function` such that all BLAS libraries that are loaded when it is called use one thread until it returns.

    Such functions may call each other. Of several threads of a process that call one, the others wait.
    """

    @functools.wraps(function)
    def limited(*values: P.args, **options: P.kwargs) -> R:
        from threadpoolctl import threadpool_limits  # 10 ms that `xneck --help` does without

        with _ONE_AT_A_TIME, threadpool_limits(limits=1, user_api="blas"):
            return function(*values, **options)

    return limited

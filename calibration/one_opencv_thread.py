"""One thread of OpenCV: several add up a sum in the order in which they end, so that its last digits are never the same."""

from collections.abc import Iterator
from contextlib import contextmanager

import cv2


@contextmanager
def one_opencv_thread() -> Iterator[None]:
    """Within this block OpenCV has one thread; for its calibration, as what it does pixel by pixel does not depend on them."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)

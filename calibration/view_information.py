"""The information of each view of a board on the camera, the board's pose being unknown."""

from collections.abc import Sequence

import cv2
import numpy as np

from calibration.corner_detection import BoardView
from calibration.one_opencv_thread import one_opencv_thread


def view_information(views: Sequence[BoardView], image_size: tuple[int, int]) -> np.ndarray | None:
    """Fisher information of each view on fx, fy, cx, cy, k1, k2, p1, p2, for equal corner errors: shape (n, 8, 8).

    These are blocks of the normal matrix with the pose eliminated, A'A - A'B (B'B)^-1 B'A, in units that make the diagonal of
    their sum one. None where no rough camera can be estimated from the views.
    """
    objects = [view.object_points.astype(np.float32) for view in views]
    images = [view.image_points.astype(np.float32).reshape(-1, 1, 2) for view in views]
    rough = np.linspace(0, len(views) - 1, min(len(views), 20)).astype(int)
    try:
        with one_opencv_thread():
            _, K, distortion, *_ = cv2.calibrateCamera(
                [objects[i] for i in rough],
                [images[i] for i in rough],
                image_size,
                np.zeros((3, 3)),
                np.zeros(5),
                flags=cv2.CALIB_FIX_K3 | cv2.CALIB_FIX_K2 | cv2.CALIB_ZERO_TANGENT_DIST,
            )
        blocks: list[np.ndarray] = []
        for points, pixels in zip(objects, images, strict=True):
            _, turn, shift = cv2.solvePnP(points, pixels, K, distortion)
            J = cv2.projectPoints(points, turn, shift, K, distortion)[1]
            A, B = J[:, 6:14], J[:, :6]
            blocks.append(A.T @ A - A.T @ B @ np.linalg.pinv(B.T @ B, hermitian=True) @ (B.T @ A))
    except cv2.error:
        return None
    information = np.array(blocks)
    scale = np.sqrt(np.einsum("nii->i", information))
    return information / np.outer(scale, scale) if np.all(np.isfinite(information)) and np.all(scale > 0) else None

"""Numbers of a model that a person sets."""

import numpy as np

from identification.model_file import covariance_of, model_of
from xneck_foundation.parameter import Parameter


def test_what_is_set_covaries_with_nothing_and_the_rest_as_before() -> None:
    """Fasquelle's width of friction was never fitted, and has no covariance."""
    parameters = [
        Parameter(name=name, index=None, value=value, unit=unit, sigma=sigma, identified=True)
        for name, value, unit, sigma in (("fs", 15.0, "N", 2.0), ("k", 9e3, "N/m", 3.0), ("ca", 60.0, "N s/m", 4.0))
    ]
    covariance = np.array([[4.0, 1.0, 2.0], [1.0, 9.0, 3.0], [2.0, 3.0, 16.0]])
    laws = ("dry_friction", "linear_cable")
    model = model_of(parameters, laws, {}, covariance).with_(k=8e3)
    assert [(p.name, p.value, p.sigma) for p in model.parameters[:3]] == [
        ("fs", 15.0, 2.0),
        ("k", 8e3, None),
        ("ca", 60.0, 4.0),
    ]
    np.testing.assert_array_equal(covariance_of(model)[:3, :3], [[4.0, 0.0, 2.0], [0.0, 0.0, 0.0], [2.0, 0.0, 16.0]])

"""Pinocchio's model as plain data, for pickles."""

from collections.abc import Mapping
from typing import cast

import numpy as np
import pinocchio as pin

from trajopt.arrays import Floats

ModelData = tuple[str, Mapping[str, Floats]]
"""The text of Pinocchio's own archive, and the vectors with infinities, which it cannot read back."""


def model_data(model: pin.Model) -> ModelData:
    """Return all that a model states."""
    finite, infinite = model.copy(), dict[str, Floats]()
    for name in dir(model):
        value: object = getattr(model, name)
        if isinstance(value, np.ndarray):
            vector = cast("Floats", value)
            if not np.isfinite(vector).all():
                infinite[name] = vector.copy()
                setattr(finite, name, np.zeros_like(vector))
    return finite.saveToString(), infinite


def model_of(data: ModelData) -> pin.Model:
    """Return the model that was stated."""
    text, infinite = data
    model = pin.Model()
    model.loadFromString(text)
    for name, vector in infinite.items():
        setattr(model, name, vector)
    return model

"""What the constructors of the nouns share: array-likes become arrays, or an error of ours."""

from math import isfinite
from operator import index as whole_number

import numpy as np
from numpy import ndarray as Array

from tracker.errors import TrackingError
from tracker.geometry import rigid_fault


def as_floats(name: str, given: object, error: type[TrackingError]) -> Array:
    """The array of float64 that was given, converted if need be; else the error, with the name."""
    if isinstance(given, Array) and given.dtype == np.float64:
        return given
    try:
        array = np.asarray(given)
        if array.dtype.kind not in "fiu" and array.size:
            raise TypeError(f"values of type {array.dtype}")
        return array.astype(np.float64)
    except (TypeError, ValueError) as reason:
        raise error(f"{name}: {reason}; give an array of numbers") from None


def as_number(name: str, given: object, error: type[TrackingError]) -> float:
    """The finite number that was given; else the error, with the name."""
    if type(given) is float and isfinite(given):
        return given
    try:
        number = float(given)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise error(f"{name} is {given!r}; give a number") from None
    if not isfinite(number):
        raise error(f"{name} is {number}; give a finite number")
    return number


def as_whole_number(name: str, given: object, error: type[TrackingError]) -> int:
    """The whole number that was given, 3 for 3.0; else the error, with the name."""
    try:
        return whole_number(given)  # type: ignore[arg-type]
    except TypeError:
        number = as_number(name, given, error)
    if number % 1.0:
        raise error(f"{name} is {number:g}; give a whole number")
    return int(number)


def as_rigid(name: str, given: object, error: type[TrackingError]) -> Array:
    """The rigid transform that was given, 4x4, or 3x4 without its last row; else the error."""
    T = as_floats(name, given, error)
    if T.shape == (3, 4):
        T = np.vstack((T, (0.0, 0.0, 0.0, 1.0)))
    if T.shape != (4, 4):
        raise error(f"{name}: its shape is {T.shape}; give [R t; 0 1], 4x4 or its first three rows")
    fault = rigid_fault(T)
    if fault is not None:
        raise error(f"{name}: {fault}")
    return T

"""Types of arrays of pixels, beside those that all kernels share."""

from numba import float32, int8, int32, uint8, uint32
from numba.types import Array

# Outputs, which the caller has made, or inputs.
OUT_F32_1, OUT_F32_2 = (Array(float32, n, "C") for n in (1, 2))
OUT_I32_1, OUT_I32_2 = (Array(int32, n, "C") for n in (1, 2))
OUT_U8_1, OUT_U8_2, OUT_U8_3 = (Array(uint8, n, "C") for n in (1, 2, 3))
OUT_U32_1, OUT_U32_2 = (Array(uint32, n, "C") for n in (1, 2))
# Inputs, which are never written to.
A32_2 = Array(float32, 2, "A", readonly=True)  # of any strides
F32_1, F32_2 = (Array(float32, n, "C", readonly=True) for n in (1, 2))
I8_2 = Array(int8, 2, "C", readonly=True)
I8_3 = Array(int8, 3, "C", readonly=True)
I32_1, I32_2 = (Array(int32, n, "C", readonly=True) for n in (1, 2))
U8_1, U8_2, U8_3 = (Array(uint8, n, "C", readonly=True) for n in (1, 2, 3))
U32_1, U32_2 = (Array(uint32, n, "C", readonly=True) for n in (1, 2))

"""Where the columns of tables lie that are packed one after the other, see `Packed`."""

from tracker.kernels.compiling import inlined_with_arrays


@inlined_with_arrays
def belief_columns(floats, n):
    """Base, yaw, size, velocity, covariance and box of so many beliefs."""
    return (
        floats[: 3 * n].reshape((n, 3)),
        floats[3 * n : 4 * n],
        floats[4 * n : 7 * n].reshape((n, 3)),
        floats[7 * n : 9 * n].reshape((n, 2)),
        floats[9 * n : 25 * n].reshape((n, 4, 4)),
        floats[25 * n : 29 * n].reshape((n, 4)),
    )


@inlined_with_arrays
def moment_columns(floats, n):
    """Seconds unseen, existence, innovations and scores of so many tracks."""
    return (
        floats[29 * n : 30 * n],
        floats[30 * n : 31 * n],
        floats[31 * n : 35 * n].reshape((n, 4)),
        floats[35 * n : 36 * n],
    )

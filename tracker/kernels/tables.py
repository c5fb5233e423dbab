"""Where the columns of tables lie that are packed one after the other, see `Packed`."""

from tracker.kernels.compiling import A_I1, F1, I1, INT, OUT1, OUT_I1, inlined_with_arrays, kernel


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


@kernel(F1, I1, I1, INT, INT, A_I1, OUT1, OUT_I1, allocates=False)
def take_rows(floats, ints, widths, whole, n, rows, out, out_whole):
    """These of n packed rows, packed; whether there are such rows, counted from the end below 0.

    widths: of the columns of floats. whole: how many columns of integers there are.
    """
    k, before = len(rows), 0
    for at in range(k):
        if not -n <= rows[at] < n:
            return False
    for width in widths:
        for at in range(k):
            source = before * n + width * (rows[at] % n)
            for number in range(width):
                out[before * k + width * at + number] = floats[source + number]
        before += width
    for column in range(whole):
        for at in range(k):
            out_whole[column * k + at] = ints[column * n + rows[at] % n]
    return True

"""Minimum-cost network flow: the best set of tracks through all detections at once, exactly.

Nodes are detections. A track is a path: it begins at one node, follows arcs to later ones, and
ends anywhere (Zhang et al., CVPR 2008). Every node lies on one path at most, so the flow is an
assignment: each node takes a successor, the end of its path, or itself (it is left out).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray as Array

from tracker.errors import BadConfig


@dataclass(frozen=True, eq=False)
class Arcs:
    """Possible links between nodes, one per row. Raises BadConfig for links that cannot be."""

    tails: Int[Array, " k"]
    """Node that each link leaves."""
    heads: Int[Array, " k"]
    """Node that follows, a larger number than the tail's."""
    costs: Float[Array, " k"]
    """What each link costs, finite; negative: it gains."""

    def __post_init__(self) -> None:
        if not np.isfinite(self.costs).all():
            bad = int((~np.isfinite(self.costs)).argmax())
            raise BadConfig(
                f"the link from node {self.tails[bad]} to {self.heads[bad]} costs "
                f"{self.costs[bad]:g}: costs are finite; leave out what is impossible"
            )
        if (self.heads <= self.tails).any():
            bad = int((self.heads <= self.tails).argmax())
            raise BadConfig(
                f"a link leads from node {self.tails[bad]} back to {self.heads[bad]}: "
                "number the nodes in the order of time"
            )


@dataclass(frozen=True, eq=False)
class Flow:
    """The cheapest tracks through all nodes."""

    links: Int[Array, "l 2"]
    """Node and next node of each link that is used, in the order of the nodes."""
    used: Bool[Array, " n"]
    """Whether each node lies on a track."""
    cost: float
    """Sum of the costs of the used nodes, links and births."""

    @property
    def tracks(self) -> Int[Array, " n"]:
        """The track of every node, numbered by their first nodes; those unused, too."""
        first = np.arange(len(self.used))
        for tail, head in self.links.tolist():  # tails in order: a chain is followed forward
            first[head] = first[tail]
        return np.unique(first, return_inverse=True)[1].astype(np.int64)


def cheapest_flow(nodes: Float[Array, " n"], births: Float[Array, " n"], arcs: Arcs) -> Flow:
    """The tracks with the smallest sum of the costs of their nodes, births and arcs.

    nodes: the cost of having each on a track (negative: it gains). births: of beginning one
    there. Ends are free; put their cost into the births. Raises BadConfig for costs that are not
    finite. Exact: successors are assigned by `min_weight_full_bipartite_matching`.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import min_weight_full_bipartite_matching

    n = len(nodes)
    own = nodes + births
    if not np.isfinite(own).all():
        bad = int((~np.isfinite(own)).argmax())
        raise BadConfig(
            f"node {bad} costs {nodes[bad]:g}, a birth there {births[bad]:g}: both must be finite"
        )
    if n == 0:
        return Flow(np.zeros((0, 2), np.int64), np.zeros(0, bool), 0.0)
    # As if each began a track of its own; a link saves a birth, leaving one out saves its own.
    gains = np.concatenate((arcs.costs - births[arcs.heads], -own, np.zeros(n)))
    every = np.arange(n)
    rows = np.concatenate((arcs.tails, every, every))
    columns = np.concatenate((arcs.heads, every, n + every))  # n + i: the path of i ends there
    kept = gains <= 0.0  # what costs more than a birth is never taken
    rows, columns, gains = rows[kept], columns[kept], gains[kept]
    shift = 1.0 - gains.min()  # explicit zeros would be no entries; every sum has n terms
    # SciPy below 1.14 solves matchings of 32-bit indices alone.
    rows, columns = rows.astype(np.int32), columns.astype(np.int32)
    graph = csr_array((gains + shift, (rows, columns)), shape=(n, 2 * n))
    graph.sum_duplicates()  # not every SciPy has done so yet
    if graph.nnz < len(gains):
        raise BadConfig("two links between the same two nodes: give the cheaper one alone")
    tails, heads = min_weight_full_bipartite_matching(graph)
    linked = (heads < n) & (heads != tails)
    used = np.ones(n, bool)
    used[tails[heads == tails]] = False
    links = np.stack((tails[linked], heads[linked]), axis=1).astype(np.int64)
    cost = own.sum() + (graph[tails, heads] - shift).sum()
    return Flow(links, used, float(cost))

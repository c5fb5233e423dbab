"""One tracker on many drives at once, each with a memory of its own: see `BatchTracker`."""

from tracker.batch.batch_costs import BatchCosts, BatchMatch
from tracker.batch.batch_tracker import BatchRows, BatchTracker
from tracker.batch.prepared_frames import PreparedFrames, prepare_frames

__all__ = [
    "BatchCosts",
    "BatchMatch",
    "BatchRows",
    "BatchTracker",
    "PreparedFrames",
    "prepare_frames",
]

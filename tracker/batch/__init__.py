"""One tracker on many drives at once, each with a memory of its own: see `BatchTracker`."""

from tracker.batch.batch_costs import BatchCosts, BatchMatch
from tracker.batch.batch_tracker import BatchRows, BatchTracker
from tracker.batch.prepared_frames import PreparedFrames, decisive_parts, prepare_frames
from tracker.batch.whole_drives import follows_together, track_drives

__all__ = [
    "BatchCosts",
    "BatchMatch",
    "BatchRows",
    "BatchTracker",
    "PreparedFrames",
    "decisive_parts",
    "follows_together",
    "prepare_frames",
    "track_drives",
]

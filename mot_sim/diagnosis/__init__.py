"""Why a tracker broke: what happened around each switch, and which noise caused it."""

from mot_sim.diagnosis.context_events import EVENT_KINDS, ContextEvents
from mot_sim.metrics.breaks import Breaks, Matches

__all__ = ["EVENT_KINDS", "Breaks", "ContextEvents", "Matches"]

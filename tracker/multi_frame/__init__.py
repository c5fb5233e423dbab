"""Association over many frames at once: a sliding window, and the whole drive."""

from tracker.multi_frame.flow_costs import FlowCosts
from tracker.multi_frame.network_flow import NetworkFlow
from tracker.multi_frame.window import Window

__all__ = ["FlowCosts", "NetworkFlow", "Window"]

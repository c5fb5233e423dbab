"""What people look at: pages, films, the map from above, the teaser."""

from mot_sim.report.film import Film, Layers
from mot_sim.report.topview import TopView

__all__ = ["Film", "Layers", "TopView"]

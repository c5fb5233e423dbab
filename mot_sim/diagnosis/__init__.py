"""Why a tracker broke: what happened around each switch, and which noise it hangs on."""

from mot_sim.diagnosis.breaks import Breaks, Matches
from mot_sim.diagnosis.happenings import KINDS, Happenings

__all__ = ["KINDS", "Breaks", "Happenings", "Matches"]

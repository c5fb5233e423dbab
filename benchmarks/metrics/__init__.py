"""Our scores against TrackEval's: the same numbers, in less time."""

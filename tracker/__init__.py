"""Multi-object tracking from one camera with geometry and shape cues (Sharma et al., ICRA 2018)."""

"""Training on renders: crops of cars with their keypoints, the keypoint network, its export."""

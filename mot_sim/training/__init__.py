"""Training on rendered images: the keypoint network, and the weights of the descriptor."""

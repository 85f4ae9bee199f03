"""What is wrong with a URDF and its linkage, or probably a mistake: findings with their problem and remedy."""

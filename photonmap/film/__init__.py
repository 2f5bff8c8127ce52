"""What passes add up to: moments, light groups, errors, bias, and when to stop."""

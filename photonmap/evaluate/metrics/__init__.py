"""Errors of one estimate against one ground truth, each exact to its source."""

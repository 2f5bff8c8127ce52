"""What results are shown with: pages of one look, plots, and files that are written whole."""

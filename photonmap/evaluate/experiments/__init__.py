"""What a data set with known light can tell about methods and metrics beyond their scores."""

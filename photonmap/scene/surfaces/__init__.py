"""What materials are made of beside colours and numbers."""

"""What a data set is published with: data card, licence, checksums, metadata, annotations."""

"""The pages and pictures of the evidence."""

"""What a curve and a wind predict for each row, with the systematic errors beside them."""

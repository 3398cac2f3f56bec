"""What a curve and a wind predict for each row, together with the systematic errors."""

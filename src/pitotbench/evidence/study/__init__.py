"""The paper's simulator study, claim by claim, and the questions that the paper does not answer."""

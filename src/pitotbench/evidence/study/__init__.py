"""The paper's simulator study, claim by claim, and the questions that it left open."""

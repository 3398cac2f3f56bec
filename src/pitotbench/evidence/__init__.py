"""What proves the product: experiments over many flights, and their pages. The product never imports it."""

"""Parts of appliances, and what is put into them."""

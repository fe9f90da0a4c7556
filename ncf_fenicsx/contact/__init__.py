"""Contact of the deformed stack: with tools and moulds, and of layers with each other."""

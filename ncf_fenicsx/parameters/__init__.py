"""What the parameters of a scene are read as: numbers with units, tables of settings, tables that choose a kind."""

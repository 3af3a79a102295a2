"""What nobody labelled: when interactions are active, which there are, and where one recording ends (paper sec. V, VII)."""

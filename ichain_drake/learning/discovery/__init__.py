"""What nobody labelled: when interactions are active, which there are, where a recording ends (paper sec. V, VII)."""

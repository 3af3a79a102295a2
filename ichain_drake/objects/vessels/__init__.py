"""What holds water: cups, kettles, tanks."""

"""The water dispenser (paper sec. VI): hand, cup, two buttons and a tank; cup and tank act on each other."""

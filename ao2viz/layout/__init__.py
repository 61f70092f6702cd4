"""Where options stand on the screen: arrays in, arrays out; numpy only."""

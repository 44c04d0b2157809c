"""Files of recorded motions: their formats, columns and units, and the motions read from them."""

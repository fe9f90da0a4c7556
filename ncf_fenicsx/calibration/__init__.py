"""From the files of testing machines to the parameters of laws."""

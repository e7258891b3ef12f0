"""Write a recording as CSV, or as HDF5 with a digest of its contents.

`writer.write_recording` takes the format from the file name's ending;
`hdf5_group` serves the trial files of the store as well.
"""

"""Write a recording as CSV, or as HDF5 with a digest of its contents.

`writer.write_recording` takes the format from the file name's ending;
`hdf5_group.write_recording_group` and `hdf5_group.file_image` serve the store's trial files.
"""

"""Read HDF5, MATLAB, MDF, Parquet and TDMS files, one format a module.

The readers are `hdf5_file.read_hdf5`, `mat_file.read_mat`, `mdf_file.read_mdf`,
`parquet_file.read_parquet` and `tdms_file.read_tdms`; `hdf5_group.group_content` reads one group.
"""

"""Sensors. Each module stands alone, so that reading events loads no kernels.

- rgb: exposure, noise and quantisation of the RGB camera
- dvs: the event camera
- events: what is made of events: counts, images
- representations: events of a fixed window as an array: counts, voxel grid, time surface, pictures
- event_files: reading and writing npz, DSEC's HDF5, AEDAT4; reading Prophesee's DAT and RAW, and ROS 2 bags
- resizing: smaller event frames that keep events: pooling, nearest neighbours
"""

"""Files of events: ``read_events`` and ``write_events`` pick the format by the file's own header or suffix.

| format | suffixes | | times | |
|---|---|---|---|---|
| npz | .npz | read, write | ns | a structured array in NumPy's zip archive: what ``pedcross generate`` writes |
| dsec | .h5 .hdf5 | read, write | us | HDF5 as in the DSEC data set; needs ``pip install 'pedcross[events]'`` |
| aedat4 | .aedat4 | read, write | us | iniVation's DV software, compressed or not |
| dat | .dat | read | us | Prophesee, decoded events |
| evt2, evt21, evt3 | .raw | read | us | Prophesee, as the sensor sends them |
| rosbag | .db3 | read | us | ROS 2 bag with event_camera_msgs/EventPacket in EVT3 |

- recording: what reading gives, and the checks that all formats share
- formats: the registry
- npz, dsec, aedat4, prophesee, rosbag: one module per family; flatbuffer is aedat4's
"""

from pedcross_env.sensors.event_files.formats import FORMATS, read_events, write_events
from pedcross_env.sensors.event_files.recording import Recording

__all__ = ["FORMATS", "Recording", "read_events", "write_events"]

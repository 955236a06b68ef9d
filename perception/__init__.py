"""Frames in, p(crossing) out: networks, data, training, checkpoints and their energy.

Import from the modules: ``perception.detector`` (the protocol), ``perception.checkpoint``
(``load_detector``), ``perception.training`` (``train``), ``perception.registry``,
``perception.preprocess``, ``perception.data``, ``perception.energy`` and ``perception.contract``
(checks for a detector of your own). This file imports nothing, so listing names stays cheap.
"""

"""Static load distribution of balls between a screw and a nut, or the rings of a bearing."""

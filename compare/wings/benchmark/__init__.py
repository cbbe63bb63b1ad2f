"""BSCB-1: twelve contact problems with the loads of every contact, for whoever writes a program for ball screws."""

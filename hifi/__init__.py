"""The 3D elastic-contact reference belongs here.

This version ships none: no command offers it, and every comparison with it is reported as open.
"""

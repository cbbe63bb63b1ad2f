"""Friction of a whole screw or bearing at the contact loads of a static model."""

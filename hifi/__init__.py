"""3D finite-element reference with elastic contact: elements, condensation of congruent patches, unilateral contact.

Independent of ``lowfi``, with which it shares only the description of the parts in ``meshes``. Verified against closed
forms.
"""

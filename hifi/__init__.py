"""The 3D elastic-contact reference: elements, condensation of congruent patches, unilateral contact, verification.

Independent of ``lowfi``; both share only the description of the parts in ``meshes``.
"""

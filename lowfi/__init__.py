"""Low-order models: contact loads, friction, lives and random errors of ball screws and bearings.

They consist of Hertz contacts, Timoshenko beams and elastic bodies of revolution. They are independent of ``hifi``; both
share only the description of the parts in ``meshes``.
"""

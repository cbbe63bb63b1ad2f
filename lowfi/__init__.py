"""Low-order models: Hertz contact, Timoshenko beam, static load distribution.

Independent of ``hifi``; both share only the description of the parts in ``meshes``.
"""

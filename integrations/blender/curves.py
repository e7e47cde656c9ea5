"""Curves of properties that are items of a collection.

Blender's curves name such items by their index, so they have to follow when a document has its colors in another order.
"""

import re


def of(animated):
    """Returns all curves that animate a data-block, of actions as they are before and after Blender 4.4."""
    data = animated.animation_data
    if data is None or data.action is None:
        return []
    found = []
    layers = getattr(data.action, "layers", None)
    if layers:
        for strip in (strip for layer in layers for strip in layer.strips):
            bag = strip.channelbag(data.action_slot) if data.action_slot else None
            found.extend(bag.fcurves if bag else [])
    else:
        found.extend(data.action.fcurves)
    return found + list(data.drivers)


def is_animated(animated, path):
    """Whether a curve or driver animates the property at a path."""
    return any(curve.data_path == path for curve in of(animated))


def renumber(animated, collection, before, after):
    """Makes curves of items of a collection follow their names from one order to another.

    A curve of an item that is gone names it, and so animates nothing until there is an item of that name again.
    """
    form = re.compile(re.escape(collection) + r'\[(?:(\d+)|"([^"]*)")\](.*)', re.DOTALL)
    for curve in of(animated):
        match = form.fullmatch(curve.data_path)
        if match is None:
            continue
        index, name, rest = match.groups()
        if name is None:
            if int(index) >= len(before):
                continue
            name = before[int(index)]
        place = after.index(name) if name in after else f'"{name}"'
        path = f"{collection}[{place}]{rest}"
        if path != curve.data_path:
            curve.data_path = path

"""Opens documents in scenes, and paints their renders: now, soon, or after each render.

Painting may take seconds, and renders run in a thread of their own. So what is painted on is taken from the scene at once,
painted in whatever thread there is, and put into Blender's data by its main thread.
"""

import contextlib
import traceback
from dataclasses import dataclass, field

import bpy
import trochoid

from . import document, image, paint, passes, plate, properties, render_result
from .work import Work

SECONDS_BETWEEN_LOOKS = 0.1
# Frames that are named if many are missing.
SHOWN = 8
# Errors whose texts say what to do.
EXPECTED = (paint.Unpaintable, image.Unwritable, OSError, trochoid.Error)


@dataclass
class State:
    """What is known of a scene while Blender runs."""

    # Frame whose passes are in the file, and their width and height; None if there are none.
    rendered: int | None = None
    size: tuple | None = None
    # Frame of the last render, whether its passes were saved or not; None if it was before the extension.
    last: int | None = None
    # What was told last, and whether it is a failure.
    told: str = ""
    has_failed: bool = False
    # What was painted on last, so that nothing is painted twice.
    painted: tuple | None = None
    # What was painted of the frame that is rendered now.
    painting: paint.Painting | None = None
    # What is changed at the frame that is rendered now, since renders animate a copy of the scene.
    animated: dict = field(default_factory=dict)
    # Frames of the last render that were not painted or not written.
    missed: list = field(default_factory=list)


STATES = {}
WORK = Work()


def state_of(scene):
    return STATES.setdefault(scene.session_uid, State())


# Opening


def open_document(scene):
    """Reads the document that a scene names, and fills its properties. Returns what is to be told: (is error, text)."""
    settings = scene.trochoid
    with properties.quietly():
        settings.faults.clear()
        if not settings.filepath:
            settings.empty()
            return []
        path = settings.path
        try:
            found = fill(scene, path)
        except Exception as error:  # One document must neither stop others nor a file from being opened.
            traceback.print_exception(error)
            found = [fault_of_extension(error)]
        settings.stamp = properties.stamp_of(path)
        for fault in found:
            item = settings.faults.add()
            item.is_error = fault["severity"] == "error"
            item.place, item.message, item.remedy = paint.place(fault, path), paint.message(fault), paint.remedy(fault)
    soon(scene)
    return [(fault.is_error, str(fault)) for fault in settings.faults]


def fill(scene, path):
    """Fills a scene's properties from a document. Returns its diagnostics."""
    try:
        read = document.read(path)
    except Exception as error:  # A faulty document fails anywhere. The program says why.
        read, failure = None, error
    found = checked(scene, path, read)
    if any(fault["severity"] == "error" for fault in found):
        return found
    if read is None:
        return [*found, fault_of_extension(failure)]
    scene.trochoid.fill(read)
    if not read.outputs:
        expected = 'an output with a "color"'
        found.append({"severity": "error", "found": "no output with colors", "expected": expected, "remedy": ""})
    found += bind(scene, read)
    # There will be a file as soon as something is rendered.
    return [fault for fault in found if not is_about(fault, render_result.path_of(scene))]


def fault_of_extension(error):
    remedy = "report it with this document"
    return {"severity": "error", "found": f"a fault of the extension, {error!r}", "expected": "a document", "remedy": remedy}


def checked(scene, path, read):
    """Returns what Trochoid says about a document, as its diagnostics."""
    text = None
    with contextlib.suppress(OSError, ValueError):
        text = document.text_of(path)
    try:
        if text is None or document.states_size(text):
            assigned = plate_of(scene) if read and read.has_plate else None
            return list(trochoid.check(path, set=assigned, allow=allowed(scene)))
        # The size is that of the render, so the document need not state one.
        found = list(trochoid.check(text, folder=path.parent, name=str(path)))
        for output in read.outputs if read else []:
            trochoid.Look.load(path, output=output)
        return found
    except trochoid.InvalidDocument as error:
        return list(error.diagnostics)
    except (trochoid.Error, OSError, ValueError) as error:
        return [{"severity": "error", "found": str(error), "expected": "a document", "remedy": "choose another file"}]


def is_about(fault, file):
    return fault["severity"] != "error" and not file.exists() and str(file) in str(fault["found"])


def plate_of(scene):
    """Returns the knob that names the file with the passes."""
    return {f"knobs.{document.PLATE}": str(render_result.path_of(scene))}


def allowed(scene):
    """Returns the folder that the document may reach besides its own, as a list."""
    folder = scene.trochoid.allow
    return [bpy.path.abspath(folder, library=scene.library)] if folder else []


def aovs(view_layer):
    """Returns the passes of a view layer's shader AOVs, by their names."""
    return {aov.name: passes.of_aov(aov.name, aov.type == "COLOR") for aov in view_layer.aovs}


def view_layer_of(scene):
    """Returns the view layer whose passes a document takes: the one that it names, or the first that is rendered."""
    named = {parts_of(scene, layer)[0] for layer in scene.trochoid.layers.split("\n")}
    rendered = [layer for layer in scene.view_layers if layer.use] or list(scene.view_layers)
    return next((layer for layer in rendered if layer.name in named), rendered[0])


def parts_of(scene, layer):
    """Returns the names of view layer and pass in that of a file's layer. Both may have dots."""
    known = [found.name for found in scene.view_layers if layer.startswith(f"{found.name}.")]
    first = max(known, key=len, default="")
    return first, layer[len(first) + 1 :] if first else ""


def bind(scene, read):
    """Lists the nodes of a document that take passes of their names. Returns diagnostics of those that cannot."""
    settings, faults = scene.trochoid, []
    unused = {binding.name for binding in settings.bindings if not binding.use}
    settings.bindings.clear()
    if read.has_plate:
        return faults
    known = {**aovs(view_layer_of(scene)), **passes.OF_NODES}
    for name in filter(known.__contains__, read.nodes):
        kinds = {kind_of(settings.path, output, name) for output in read.outputs} - {None}
        if "mask" in kinds and known[name].meaning in ("DEPTH", "PLACE", "DIRECTION"):
            fault = {"severity": "warning", "node": name, "found": "a mask", "expected": f"a field, as {known[name].label} is"}
            faults.append({**fault, "remedy": "make it a FieldMath, or call it otherwise: it takes no pass"})
        # A node of colors takes none: colors are the palette's.
        elif kinds & {"mask", "field"}:
            binding = settings.bindings.add()
            binding.name, binding.source, binding.use = name, known[name].label, name not in unused
    return faults


def kind_of(path, output, name):
    """Returns the kind of a node, if a pass can take its place and the output depends on it."""
    try:
        look = trochoid.Look.load(path, output=output, inputs=[name])
    except (trochoid.Error, ValueError, OSError):
        return None
    return next((slot.kind for slot in look.slots if slot.is_used), None)


# Passes that are off


def passes_off(scene):
    """Returns the passes that the document needs and the view layer has switched off: (label, switch or "", layer's name)."""
    settings, view_layer = scene.trochoid, view_layer_of(scene)
    needed = []
    strange = []
    for layer in filter(None, settings.layers.split("\n")):
        first, name = parts_of(scene, layer)
        if not name:
            strange.append((layer, "", ""))
        elif (switch := passes.switch_of(name)) is not None:
            needed.append((*switch, scene.view_layers[first]))
            if is_called_otherwise(name):
                strange.append((name, "", first))
        elif name.split(".")[0] not in aovs(scene.view_layers[first]):
            strange.append((name, "", first))
    if settings.reads_objects and not any(is_on(view_layer, switch) for _, switch in passes.OBJECTS.values()):
        needed.append((*passes.OBJECTS["CryptoObject"], view_layer))
    for binding in settings.bindings:
        known = passes.OF_NODES.get(binding.name)
        if binding.use and known:
            needed.append((known.label, known.switch, view_layer))
    off = [(label, switch, layer.name) for label, switch, layer in needed if not is_on(layer, switch)]
    return list(dict.fromkeys(off + strange))


def name_here(name):
    """Returns what a pass is called in files of this Blender."""
    known = passes.OF_NAMES.get(name.split(".")[0])
    return known and known.names[0 if bpy.app.version >= (5, 0) else -1]


def is_called_otherwise(name):
    return name_here(name) not in (None, name.split(".")[0])


def is_on(view_layer, switch):
    owner, name = owner_of(view_layer, switch)
    return not switch or getattr(owner, name, False)


def owner_of(view_layer, switch):
    """Returns the object that has a switch, and its name: `cycles.use_pass_…` is one of Cycles' own."""
    group, _, name = switch.rpartition(".")
    return (getattr(view_layer, group, None) if group else view_layer), name


def sentence_of_pass(off):
    """Says what to switch on."""
    label, switch, layer = off
    if switch:
        return f'the pass {label} is off in the view layer "{layer}"; switch it on and render again'
    if is_called_otherwise(label):
        return f'files of this Blender have the pass {label} as "{name_here(label)}"; name it so in the document'
    if layer:
        return f'the view layer "{layer}" has no pass and no shader AOV "{label}"; add it, or name another in the document'
    return f'the document reads the layer "{label}", but no view layer has the name before its dot; rename one of the two'


def frames_missed(scene):
    """Says which frames of the last render were not painted or not written; empty if all were."""
    missed = state_of(scene).missed
    if len(missed) < 2 and state_of(scene).has_failed:
        # That is told already.
        return ""
    numbers = ", ".join(map(str, missed[:SHOWN])) + (", …" if len(missed) > SHOWN else "")
    return f"Frames without a painting, as the system console says: {numbers}" if missed else ""


# Painting


def request(scene, frame=None, values=None):
    """Takes from a scene what to paint. Raises paint.Unpaintable."""
    settings = scene.trochoid
    if not settings.filepath:
        raise paint.Unpaintable("found no graph; expected one: open a document in the panel Trochoid")
    if not settings.is_valid:
        faults = [str(fault) for fault in settings.faults if fault.is_error]
        raise paint.Unpaintable("\n".join(faults) or "the document has no output with colors")
    path = render_result.path_of(scene)
    state = state_of(scene)
    if state.rendered is None or not path.exists():
        keep_passes(scene)
    known = {**aovs(view_layer_of(scene)), **passes.OF_NODES}
    assigned = settings.assignments() if values is None else values
    if settings.has_plate:
        assigned = {**assigned, **plate_of(scene)}
    return paint.Request(
        document=settings.path,
        stamp=settings.stamp,
        output=settings.output,
        layer=dict(zip(settings.outputs.split("\n"), settings.layers_of_outputs.split("\n"))).get(settings.output, ""),
        space=settings.space,
        set=assigned,
        frame=scene.frame_current if frame is None else frame,
        plate=path,
        view_layer=view_layer_of(scene).name,
        has_plate=settings.has_plate,
        allow=allowed(scene),
        render_size=state.size,
        size=tuple(settings.document_size),
        bound={binding.name: known[binding.name] for binding in settings.bindings if binding.use and binding.name in known},
        scale=scene.unit_settings.scale_length,
        rendered=state.rendered,
    )


def keep_passes(scene):
    """Saves the passes of the last render. Raises OSError if there is none, or if that fails."""
    state = state_of(scene)
    with paint.PASSES:
        state.size = plate.size_of(render_result.save(scene))
    state.rendered = scene.frame_current if state.last is None else state.last


def before_render(scene):
    """Forgets what is being painted: it has the passes of the last render, or of none if they change meanwhile."""
    state = state_of(scene)
    state.missed = []
    if WORK.forget(scene.session_uid):
        # What was changed is not painted yet.
        state.painted = None
    for other in STATES.values():
        other.animated.clear()


def after_render(scene):
    """Keeps the passes of a frame that was just rendered, and paints it. In whatever thread renders; never raises."""
    settings = scene.trochoid
    state = state_of(scene)
    # That of a still which was not written, or of a graph that is closed now.
    state.painting = None
    # What was saved is of the render before. If nobody wants this one painted now, Paint fetches its passes.
    state.rendered, state.last = None, scene.frame_current
    if not (settings.filepath and settings.repaint):
        return
    number = WORK.ask(scene.session_uid)
    try:
        keep_passes(scene)
        wanted = request(scene, values=state.animated.get(scene.frame_current))
        state.painted = fingerprint(wanted)
        state.painting = WORK.finish(scene.session_uid, number, wanted)
    except Exception as error:  # A render must go on, whatever happens to its painting.
        WORK.put(scene.session_uid, number, error)
    if state.painting is None:
        state.missed.append(scene.frame_current)
    if not has_window():
        deliver_all()


def after_write(scene):
    """Writes the frame that was just painted, since Blender wrote its own. Never raises."""
    state = state_of(scene)
    painting, state.painting = state.painting, None
    if painting is None:
        return
    try:
        file = image.frame_file(scene, painting.request.frame)
        if file is not None:
            paint.write(painting, file)
    except Exception as error:  # As above.
        state.missed.append(painting.request.frame)
        WORK.put(scene.session_uid, WORK.ask(scene.session_uid), error)
        if not has_window():
            deliver_all()


def after_all(scene):
    """Lets the main thread paint what was changed while Blender rendered."""
    state_of(scene).painting = None
    WORK.has_rendered = True
    if not has_window():
        paint_changes()


def paint_changes():
    """Paints what was changed while Blender rendered. In the main thread only."""
    if not WORK.has_rendered or WORK.is_rendering:
        return
    WORK.has_rendered = False
    for scene in bpy.data.scenes:
        if scene.trochoid.filepath and scene.frame_current == state_of(scene).rendered:
            soon(scene)


def now(scene):
    """Paints, and waits for it. Returns the painting. Raises paint.Unpaintable or OSError."""
    if properties.stamp_of(scene.trochoid.path) != scene.trochoid.stamp:
        open_document(scene)
    if WORK.is_rendering and state_of(scene).rendered is None:
        raise paint.Unpaintable("found a render under way; expected one that is done: paint after it")
    number = WORK.ask(scene.session_uid)
    painting = paint.paint(request(scene))
    WORK.put(scene.session_uid, number, painting)
    deliver_all()
    return painting


def deliver(scene, painting):
    """Puts a painting into the scene's image. In the main thread only."""
    state = state_of(scene)
    image.show(scene, painting)
    state.told, state.has_failed = painting.told, False
    state.painted = fingerprint(painting.request)


def fail(scene, error):
    state = state_of(scene)
    if state.has_failed and state.told == in_words(error):
        # Or the console would be full of it after a few changes.
        return
    state.told, state.has_failed = in_words(error), True
    print(f"Trochoid: {state.told}")
    if not isinstance(error, EXPECTED):
        traceback.print_exception(error)


def in_words(error):
    """Says what went wrong. Only errors that somebody expected say it themselves."""
    if isinstance(error, EXPECTED):
        return str(error)
    return f"found a fault of the extension, {error!r}; expected a painting: report it with what the system console says"


def fingerprint(wanted):
    """Returns what tells whether two requests make the same picture."""
    assigned = tuple(sorted((name, str(value)) for name, value in wanted.set.items()))
    return (
        wanted.document,
        wanted.stamp,
        wanted.output,
        assigned,
        wanted.frame,
        wanted.rendered,
        wanted.render_size,
        tuple(wanted.bound),
    )


def soon(scene):
    """Paints again after a change, if the scene wants it and there are passes. Newer changes replace older ones."""
    settings = scene.trochoid
    if not (settings.live and settings.is_valid and state_of(scene).rendered is not None) or WORK.is_rendering:
        return
    try:
        wanted = request(scene)
    except Exception as error:  # Handlers call this for any change in the scene, which must go on.
        fail(scene, error)
        return
    if fingerprint(wanted) != state_of(scene).painted:
        state_of(scene).painted = fingerprint(wanted)
        if has_window():
            WORK.add(scene.session_uid, wanted)
        else:
            # Nothing would ever call the main thread.
            WORK.finish(scene.session_uid, WORK.ask(scene.session_uid), wanted)
            deliver_all()


def has_window():
    """Whether somebody looks, so that Blender calls timers."""
    return not bpy.app.background


def deliver_all():
    """Puts what is painted into Blender's data, and tells what failed. In the main thread only. Returns whether any was."""
    done = WORK.take()
    for scene in bpy.data.scenes:
        for result in done.get(scene.session_uid, []):
            try:
                if isinstance(result, paint.Painting):
                    deliver(scene, result)
                else:
                    fail(scene, result)
            except Exception as error:  # Or nothing would be delivered again.
                fail(scene, error)
    return bool(done)


def tick():
    """Called by Blender's main thread now and then."""
    try:
        paint_changes()
        is_busy = WORK.thread is not None
        if deliver_all() or is_busy:
            image.redraw()
    except Exception as error:  # Blender would never call it again.
        traceback.print_exception(error)
    return SECONDS_BETWEEN_LOOKS


def forget():
    """Forgets all scenes, and what was kept of their renders."""
    WORK.forget_all()
    WORK.is_rendering = False
    STATES.clear()
    with paint.PASSES:
        render_result.remove_all()


def register():
    properties.Calls.changed, properties.Calls.reread = soon, open_document
    if has_window():
        bpy.app.timers.register(tick, persistent=True)


def unregister():
    properties.Calls.changed = properties.Calls.reread = None
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
    forget()

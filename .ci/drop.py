"""drop.py WINDOW FILE: drops a file on a window at the pointer, as a file manager does (XDND, version 5)."""
import pathlib
import select
import sys
import time

from Xlib import X, Xatom, display
from Xlib.protocol import event

screen = display.Display()
target = screen.create_resource_object("window", int(sys.argv[1]))
root = screen.screen().root
source = root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)
name = {
    word: screen.intern_atom(word)
    for word in ["XdndAware", "XdndSelection", "XdndEnter", "XdndPosition", "XdndStatus", "XdndDrop", "XdndFinished",
                 "XdndActionCopy", "text/uri-list", "TARGETS"]
}
if target.get_full_property(name["XdndAware"], X.AnyPropertyType) is None:
    sys.exit("the window takes no drops")
data = (pathlib.Path(sys.argv[2]).resolve().as_uri() + "\r\n").encode()


def tell(kind, *numbers):
    numbers = [source.id, *numbers] + [0] * (4 - len(numbers))
    message = event.ClientMessage(window=target, client_type=name[kind], data=(32, numbers))
    target.send_event(message)
    screen.flush()


def give(request):
    """Answers a request for the dropped names."""
    place = request.property or request.target
    if request.target == name["TARGETS"]:
        request.requestor.change_property(place, Xatom.ATOM, 32, [name["text/uri-list"]])
    else:
        request.requestor.change_property(place, request.target, 8, data)
    request.requestor.send_event(event.SelectionNotify(
        time=request.time, requestor=request.requestor, selection=request.selection, target=request.target,
        property=place))
    screen.flush()


def wait_for(kind):
    """Waits for a message of the target, and gives it the names when it asks for them."""
    end = time.monotonic() + 30
    while time.monotonic() < end:
        while screen.pending_events():
            found = screen.next_event()
            if found.type == X.SelectionRequest:
                give(found)
            elif found.type == X.ClientMessage and found.client_type == name[kind]:
                return found.data[1]
        select.select([screen], [], [], 0.1)
    sys.exit(f"the window has sent no {kind}")


source.set_selection_owner(name["XdndSelection"], X.CurrentTime)
pointer = root.query_pointer()
tell("XdndEnter", 5 << 24, name["text/uri-list"])
tell("XdndPosition", 0, pointer.root_x << 16 | pointer.root_y, X.CurrentTime, name["XdndActionCopy"])
if not wait_for("XdndStatus")[1] & 1:
    sys.exit("the window refuses the file")
tell("XdndDrop", 0, X.CurrentTime)
wait_for("XdndFinished")

"""Paints what is asked for, and keeps what comes of it for the main thread. This module needs no Blender.

Requests are numbered, for one that began before another of its scene may be done after it. Then it comes to nothing.
"""

import itertools
import threading

import trochoid

from . import paint


class Work:
    """Paints in a thread of its own, one request at a time, or in the thread that asks. Scenes have numbers."""

    def __init__(self):
        self.lock = threading.Lock()
        self.numbers = itertools.count(1)
        # What waits for the thread, by scene, with its number: only the newest counts.
        self.wanted = {}
        # The newest request of each scene, and the newest of which it is known what came of it.
        self.newest, self.known = {}, {}
        # What the main thread has not yet taken, by scene: the newest painting, and what failed after it.
        self.done = {}
        # The scene that the thread paints, and the part of it that is done.
        self.painted, self.progress = None, None
        self.thread = None
        # Whether Blender renders, and whether it has done so since changes were last painted.
        self.is_rendering = self.has_rendered = False

    def ask(self, uid):
        """Returns the number of a new request. What is being painted of an older one stops."""
        with self.lock:
            self.wanted.pop(uid, None)
            self.newest[uid] = next(self.numbers)
            return self.newest[uid]

    def forget(self, uid):
        """Lets all requests of a scene come to nothing, even if they are being painted. Returns whether there were any."""
        with self.lock:
            waited = self.wanted.pop(uid, None)
            self.newest[uid] = self.known[uid] = next(self.numbers)
            return waited is not None or self.painted == uid

    def forget_all(self):
        """Lets all requests come to nothing, and what was not yet taken."""
        for uid in list(self.newest):
            self.forget(uid)
        with self.lock:
            self.done.clear()

    def add(self, uid, request):
        """Asks the thread to paint."""
        number = self.ask(uid)
        with self.lock:
            self.wanted[uid] = (number, request)
            if self.thread is None:
                self.thread = threading.Thread(target=self.run, name="trochoid", daemon=True)
                self.thread.start()

    def run(self):
        while True:
            with self.lock:
                self.painted = self.progress = None
                if not self.wanted:
                    self.thread = None
                    return
                uid, (number, request) = self.wanted.popitem()
                self.painted, self.progress = uid, 0.0

            def go_on(done, total, uid=uid, number=number):
                self.progress = done / max(total, 1)
                return self.newest[uid] == number

            self.finish(uid, number, request, go_on)

    def finish(self, uid, number, request, go_on=paint.go_on):
        """Paints in this thread. Returns the painting; None if there is none."""
        try:
            painting = paint.paint(request, go_on)
        except trochoid.Cancelled:
            return None
        except Exception as error:  # Whatever it is, the main thread tells it.
            self.put(uid, number, error)
            return None
        self.put(uid, number, painting)
        return painting

    def put(self, uid, number, result):
        """Keeps a painting or an error for the main thread, unless something newer is known."""
        with self.lock:
            if number < self.known.get(uid, 0):
                return
            self.known[uid] = number
            kept = self.done.get(uid, [])
            if isinstance(result, paint.Painting):
                self.done[uid] = [result]
            else:
                self.done[uid] = [*(one for one in kept if isinstance(one, paint.Painting)), result]

    def take(self):
        """Returns what came of requests since the last call: paintings and errors, by scene."""
        with self.lock:
            done, self.done = self.done, {}
        return done

    def progress_of(self, uid):
        """Returns the part that is done of what the thread paints of a scene; None if it paints nothing of it."""
        return self.progress if self.painted == uid else None

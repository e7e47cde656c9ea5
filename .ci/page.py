"""Drives pages of recipes in a headless Chromium; `.ci/page` says how."""

import base64
import io
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import OpenEXR
from PIL import Image, ImageChops, ImageFilter
from playwright.sync_api import expect as wait_until
from playwright.sync_api import sync_playwright

TROCHOID = os.environ["TROCHOID"]
# WebGL without a graphics card.
OPTIONS = ["--enable-unsafe-swiftshader"]
NO_WEBGL = """
const original = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith("webgl") ? null : original.call(this, kind, ...more);
};
"""

# Mixes of few and of many colors, soft and hard edges, at two frames.
SCENE = {
    "trochoid": 1,
    "format": {"width": 160, "height": 90},
    "working_space": "srgb",
    "frames": {"first": 1, "last": 2, "fps": 24},
    "palette": {"night": "#101a33", "dusk": "#5a3f5e", "sun": "#f0cf8e", "foam": "#e8f4ff", "moss": "#2f6b3a", "red": "#ff0000"},
    "nodes": {
        "x": {"type": "ScreenX"},
        "y": {"type": "ScreenY"},
        "n": {"type": "Noise", "scale": {"keys": [[1, 5], [2, 7]]}},
        "m": {"type": "Clamp", "field": "n", "min": -0.5, "max": 0.5},
        "sky": {"type": "Mix", "a": "palette.dusk", "b": "palette.sun", "weight": "x"},
        "sea": {"type": "Mix", "a": "palette.night", "b": "palette.foam", "weight": "m"},
        "all": {"type": "Mix", "a": "sky", "b": "sea", "weight": "y"},
        "disc": {"type": "Shape", "shapes": [{"form": "disc", "center": [0.4, 0.3], "radius": 0.1}]},
        "sign": {"type": "Mix", "a": "all", "b": "palette.red", "weight": "disc"},
        "land": {"type": "Mix", "a": "sign", "b": "palette.moss", "weight": 0.25},
    },
    "outputs": {"land": {"color": "land", "file": "land.####.png"}},
}
# The scene as it is rendered, and its weights in working spaces of linear light.
PICTURES = ("land", "linear-srgb", "acescg")


def run(folder, *arguments):
    done = subprocess.run([TROCHOID, *map(str, arguments)], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"failed: trochoid {' '.join(map(str, arguments))}\n{done.stderr}")


def expect(holds, what):
    if not holds:
        sys.exit(f"failed: {what}")


def in_space(folder, space):
    """Copies the recipes into another working space: the same weights, of colors that mix as light."""
    for frame in (1, 2):
        with OpenEXR.File(str(folder / f"land.000{frame}.exr")) as file:
            recipe = json.loads(file.header()["trochoid:recipe"])
            header = {"type": OpenEXR.scanlineimage, "trochoid:recipe": json.dumps({**recipe, "working_space": space})}
            channels = {name: channel.pixels.copy() for name, channel in file.channels().items()}
        # Half of the picture is darkened, where the display is steepest: the first color takes what the others lose.
        for pixels in channels.values():
            pixels[:, :80] = numpy.floor(pixels[:, :80].astype("f8") * 64) / 2048
        rest = 1 - sum(pixels.astype("f8") for pixels in channels.values())
        channels["recipe.night.Y"] = (channels["recipe.night.Y"] + rest).astype("f2")
        with OpenEXR.File(header, channels) as file:
            file.write(str(folder / f"{space}.000{frame}.exr"))


def made(folder):
    """Writes a page with two frames and a palette, and returns the palettes that pictures are compared in."""
    (folder / "scene.json").write_text(json.dumps(SCENE))
    run(folder, "render", "scene.json")
    run(folder, "decompose", "land.0001.png", "land.0002.png", "--palette", "scene.json", "--softness", "0.3", "--out", "{name}.exr")
    draw = random.Random(1)
    names = list(SCENE["palette"])
    palettes = {
        "original": SCENE["palette"],
        # Every second color black and white: what rounding does is seen most.
        "stark": {name: "#000000" if at % 2 else "#ffffff" for at, name in enumerate(names)},
        "random": {name: f"#{draw.randrange(1 << 24):06x}" for name in names},
        "one": {"sun": "#ff00ff"},
    }
    for name, palette in palettes.items():
        (folder / f"{name}.json").write_text(json.dumps(palette))
    chosen = [part for name in palettes for part in ("--palette", f"{name}.json")]
    for picture in PICTURES:
        if picture != "land":
            in_space(folder, picture)
        title = ("--title", "<b>Land & sea</b>")
        run(folder, "page", f"{picture}.####.exr", "--frames", "1-2", *chosen, *title, "-o", f"{picture}.html")
        for name in palettes:
            for frame in (1, 2):
                files = (f"{picture}.000{frame}.exr", "--palette", f"{name}.json", "-o", f"{picture}.{name}.{frame}.png")
                run(folder, "recolor", *files)
    return palettes


class Page:
    def __init__(self, browser, file, webgl=True, script="", **options):
        self.context = browser.new_context(viewport={"width": 1280, "height": 800}, accept_downloads=True, **options)
        self.page = self.context.new_page()
        self.asked, self.faults = [], []
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("pageerror", lambda error: self.faults.append(str(error)))
        self.page.on("console", lambda said: said.type == "error" and self.faults.append(said.text))
        self.page.add_init_script(script + ("" if webgl else NO_WEBGL))
        self.page.goto(f"file://{file}")
        self.page.wait_for_selector("#wait", state="hidden")

    def picture(self):
        """Returns what is painted, once the page has painted it."""
        data = self.page.evaluate(
            """() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() =>
            done(document.querySelector("#frame > canvas").toDataURL()))))"""
        )
        return Image.open(io.BytesIO(base64.b64decode(data.split(",")[1]))).convert("RGB")

    def saved(self, kind):
        with self.page.expect_download() as download:
            self.page.click(f"[data-save={kind}]")
        return Path(download.value.path())

    def swatch(self, at):
        return self.page.locator("#swatches > *").nth(at)

    def end(self):
        expect(not self.faults, f"the page said {self.faults}")
        expect(all(url.startswith(("file:", "blob:")) for url in self.asked), f"the page asked for {self.asked}")
        self.context.close()


def apart(a, b):
    return max(high for _, high in ImageChops.difference(a, b.convert("RGB")).getextrema())


def check_pixels(browser, folder, picture, palettes, webgl):
    page = Page(browser, folder / f"{picture}.html", webgl)
    kind = page.page.evaluate("() => document.querySelector('#frame > canvas').getContext('2d') ? '2d' : 'webgl2'")
    expect(kind == ("webgl2" if webgl else "2d"), f"the page paints with {kind}")
    farthest = 0
    for name in palettes:
        page.page.select_option("#palettes", label=name)
        for frame in (1, 2):
            page.page.locator("#scrub").fill(str(frame - 1))
            wait_until(page.page.locator("#at")).to_have_text(f"{frame} / 2")
            off = apart(page.picture(), Image.open(folder / f"{picture}.{name}.{frame}.png"))
            expect(off <= 1, f"{picture}, {name}, frame {frame}, {kind}: found pixels {off} of 255 apart from recolor; expected 1")
            farthest = max(farthest, off)
    page.end()
    print(f"{picture}, {kind}: {2 * len(palettes)} pictures equal those of recolor within {farthest} of 255")


def check_controls(browser, folder, webgl):
    page = Page(browser, folder / "land.html", webgl)
    it = page.page
    expect(it.locator("h1").text_content() == "<b>Land & sea</b>", "the title is not what was given")
    original = page.picture()
    # A color is typed, and the palette saved.
    it.keyboard.press("Tab")
    page.swatch(2).click()
    it.fill("#hex", "#ff00ff")
    it.keyboard.press("Enter")
    off = apart(page.picture(), Image.open(folder / "land.one.1.png"))
    expect(off <= 1, f"found a typed color {off} of 255 apart from recolor")
    saved = json.loads(page.saved("json").read_text())
    expect(saved["palette"] == {**SCENE["palette"], "sun": "#ff00ff"}, f"saved {saved}")
    expect("255   0 255\tsun\n" in page.saved("gpl").read_text(), "the saved .gpl lacks the typed color")
    expect(apart(page.picture(), Image.open(page.saved("png"))) == 0, "the saved picture is not what is painted")
    # A saved palette is one that other commands read; a LUT repaints the picture as the page does.
    shutil.copy(page.saved("gpl"), folder / "saved.gpl")
    run(folder, "recolor", "land.0001.exr", "--palette", "saved.gpl", "-o", "saved.png")
    check_cube(page.saved("cube"), original, page.picture())
    # The divider shows the original to its left.
    it.click("#compare")
    half = page.picture()
    middle = half.width // 2
    left, right = (0, 0, middle, half.height), (middle, 0, half.width, half.height)
    expect(apart(half.crop(left), original.crop(left)) == 0, "left of the divider is not the original")
    expect(apart(half.crop(right), original.crop(right)) > 50, "right of the divider is the original")
    it.focus("#split")
    it.keyboard.press("End")
    expect(apart(page.picture(), original) == 0, "the divider at the end does not show the original")
    it.click("#compare")
    it.keyboard.press("Tab")
    it.keyboard.down("o")
    expect(apart(page.picture(), original) == 0, "holding o does not show the original")
    it.keyboard.up("o")
    it.click("#reset")
    expect(apart(page.picture(), original) == 0, "reset does not bring the original back")
    # By keyboard alone: the next color, its lightness.
    page.swatch(2).focus()
    it.keyboard.press("ArrowRight")
    expect(page.swatch(3).get_attribute("aria-checked") == "true", "an arrow key does not choose the next color")
    it.focus("#l")
    for _ in range(5):
        it.keyboard.press("ArrowLeft")
    wait_until(it.locator("#said")).to_contain_text("foam, #")
    # By dragging.
    box = page.swatch(0).bounding_box()
    before = page.swatch(0).get_attribute("aria-label")
    it.mouse.move(box["x"] + 20, box["y"] + 20)
    it.mouse.down()
    it.mouse.move(box["x"] + 20, box["y"] - 60, steps=4)
    it.mouse.up()
    expect(page.swatch(0).get_attribute("aria-label") != before, "dragging a swatch changes nothing")
    # Escape puts a dragged color back, and ends the drag.
    kept = page.picture()
    for box in (page.swatch(0).bounding_box(), it.locator("#field").bounding_box()):
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        it.mouse.move(x, y)
        it.mouse.down()
        it.mouse.move(x + 30, y - 40, steps=4)
        expect(apart(page.picture(), kept) > 0, "dragging paints nothing")
        it.keyboard.press("Escape")
        it.mouse.move(x + 60, y - 60, steps=4)
        it.mouse.up()
        expect(apart(page.picture(), kept) == 0, "Escape does not put a dragged color back")
    # A warning of colors that nobody can tell apart.
    page.swatch(0).click()
    it.fill("#hex", "#5a3f5f")
    it.keyboard.press("Enter")
    expect("look alike" in it.locator("#warnings").text_content(), "colors that look alike are not told")
    # Frames play.
    it.click("#play")
    wait_until(it.locator("#at")).to_have_text("2 / 2")
    it.click("#play")
    page.end()
    print("controls, keyboard, divider, warnings and exports do what they say")


def check_pictures(browser, folder):
    """Several pictures on a page: each is painted, and a changed color is changed in all."""
    shutil.copy(folder / "land.0002.exr", folder / "sea.exr")
    run(folder, "page", "land.0001.exr", "sea.exr", "-o", "two.html")
    page = Page(browser, folder / "two.html")
    page.swatch(2).click()
    page.page.fill("#hex", "#ff00ff")
    for turn in range(6):
        page.page.select_option("#pictures", index=turn % 2)
        wait_until(page.page.locator("#facts")).to_contain_text("sea" if turn % 2 else "land")
        off = apart(page.picture(), Image.open(folder / f"land.one.{turn % 2 + 1}.png"))
        expect(off <= 1, f"found a picture of several {off} of 255 apart from recolor")
    expect(page.page.evaluate("() => !document.querySelector('#frame > canvas').getContext('2d')"), "WebGL2 was lost")
    page.end()
    print("several pictures are painted in one palette")


def check_cube(file, original, painted):
    lines = file.read_text().splitlines()
    start = lines.index("LUT_3D_SIZE 33") + 1
    nodes = [tuple(map(float, line.split())) for line in lines[start:]]
    expect(len(nodes) == 33**3, f"found {len(nodes)} colors in the LUT")
    lut = ImageFilter.Color3DLUT(33, nodes)
    off = ImageChops.difference(original.filter(lut), painted).convert("L").histogram()
    near = sum(off[:5]) / sum(off)
    expect(near > 0.99, f"only {near:.1%} of the pixels come within 4 of 255 of the LUT")


def check(browser):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        palettes = made(folder)
        for webgl in (True, False):
            for picture in PICTURES:
                check_pixels(browser, folder, picture, palettes, webgl)
            check_controls(browser, folder, webgl)
        check_pictures(browser, folder)
        for width, scheme in ((1280, "light"), (390, "dark")):
            page = Page(browser, folder / "land.html", color_scheme=scheme)
            page.page.set_viewport_size({"width": width, "height": 800})
            wide = page.page.evaluate("document.documentElement.scrollWidth")
            expect(wide <= width, f"found a page {wide} wide in a window of {width}")
            page.end()


# Counts how often the picture, which is wider than the editor's field, is painted.
COUNTED = """
window.paints = 0;
const draw = WebGL2RenderingContext.prototype.drawArrays;
WebGL2RenderingContext.prototype.drawArrays = function (...all) { window.paints++; return draw.apply(this, all); };
const put = CanvasRenderingContext2D.prototype.putImageData;
CanvasRenderingContext2D.prototype.putImageData = function (image, ...all) {
  window.paints += image.width > 200;
  return put.call(this, image, ...all);
};
"""

# Drags the first color for four seconds, by as many moves as the display shows.
DRAGGED = """async () => {
  const swatch = document.querySelector("#swatches > *");
  const move = (kind, x, y) => swatch.dispatchEvent(new PointerEvent(kind, { button: 0, pointerId: 1, clientX: x, clientY: y }));
  swatch.setPointerCapture = () => {};
  move("pointerdown", 100, 100);
  const end = performance.now() + 4000;
  for (let at = 0; performance.now() < end; at++) {
    move("pointermove", 110 + at % 60, 100 - at % 40);
    await new Promise(requestAnimationFrame);
  }
  move("pointerup", 100, 100);
}"""


def time(browser, file):
    print(f"{file.stat().st_size / 1e6:.1f} MB")
    for webgl in (True, False):
        page = Page(browser, file, webgl, COUNTED)
        it = page.page
        opened = it.evaluate("performance.getEntriesByName('shown')[0].startTime")
        it.wait_for_timeout(5000)

        def paints(act):
            before, since = it.evaluate("[window.paints, performance.now()]")
            act()
            after, until = it.evaluate("[window.paints, performance.now()]")
            return 1000 * (after - before) / (until - since)

        dragged = paints(lambda: it.evaluate(DRAGGED))
        played = 0
        if it.locator("#play").is_visible():
            it.click("#play")
            played = paints(lambda: it.wait_for_timeout(4000))
        print(
            f"{'WebGL2' if webgl else 'canvas'}: the picture after {opened:.0f} ms; "
            f"{dragged:.0f} frames/s while a color is dragged, {played:.0f} while frames play"
        )
        page.context.close()


def picture(browser, file, out):
    page = Page(browser, file)
    page.page.set_viewport_size({"width": 1180, "height": 760})
    page.page.select_option("#palettes", index=page.page.locator("#palettes option").count() - 1)
    page.page.click("#compare")
    page.swatch(2).click()
    # The editor follows the picture after a pause.
    page.page.wait_for_timeout(500)
    shown = Image.open(io.BytesIO(page.page.screenshot(clip={"x": 0, "y": 0, "width": 1180, "height": 546})))
    shown.convert("RGB").quantize(256).save(out, optimize=True)
    page.context.close()


with sync_playwright() as playwright:
    browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=OPTIONS)
    if sys.argv[1:2] == ["time"]:
        time(browser, Path(sys.argv[2]).resolve())
    elif sys.argv[1:2] == ["picture"]:
        picture(browser, Path(sys.argv[2]).resolve(), sys.argv[3])
    else:
        check(browser)
        print("passed")
    browser.close()

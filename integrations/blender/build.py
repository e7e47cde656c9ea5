"""Builds the extension: `python build.py WHEEL…` writes trochoid-VERSION.zip, which Blender installs from disk.

Each wheel is one of the package `trochoid` for a platform, as `maturin build --release` makes it in crates/python.
"""

import argparse
import re
import tomllib
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
# What tags of wheels are called in manifests.
PLATFORMS = {
    r"linux_x86_64": "linux-x64",
    r"linux_aarch64": "linux-arm64",
    r"macosx_.*_arm64": "macos-arm64",
    r"macosx_.*_x86_64": "macos-x64",
    r"win_amd64": "windows-x64",
    r"win_arm64": "windows-arm64",
}


def platform_of(wheel):
    """Returns the platform of a wheel by its name, which ends in the platforms that it is for."""
    tags = wheel.stem.split("-")[-1].split(".")
    for tag in tags:
        for form, platform in PLATFORMS.items():
            if re.fullmatch(form, re.sub(r"^(many|musl)linux_?\d+(_\d+)?_", "linux_", tag)):
                return platform
    raise SystemExit(f"{wheel}: found the platforms {', '.join(tags)}; expected one that Blender runs on")


def manifest(wheels):
    """Returns the manifest with the wheels and their platforms."""
    text = (HERE / "blender_manifest.toml").read_text()
    named = "".join(f'  "./wheels/{wheel.name}",\n' for wheel in wheels)
    platforms = ", ".join(sorted({f'"{platform_of(wheel)}"' for wheel in wheels}))
    return text.replace("wheels = []\n", f"wheels = [\n{named}]\nplatforms = [{platforms}]\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("wheels", nargs="+", type=Path, help="wheels of the package trochoid")
    parser.add_argument("--out", type=Path, default=Path("."), help="folder to write to")
    arguments = parser.parse_args()
    told = manifest(arguments.wheels)
    out = arguments.out / f"trochoid-{tomllib.loads(told)['version']}.zip"
    out.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("blender_manifest.toml", told)
        for file in sorted([*HERE.glob("*.py"), HERE / "README.md"]):
            if file.name != Path(__file__).name:
                archive.write(file, file.name)
        for wheel in arguments.wheels:
            archive.write(wheel, f"wheels/{wheel.name}")
    print(out)


if __name__ == "__main__":
    main()

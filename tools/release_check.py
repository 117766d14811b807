"""Everything that is asked of a release, short of publishing it.

    python tools/release_check.py [--out dist]        (make release-check)

Builds this commit twice, in two clones, and compares the hashes; installs the wheel into an environment of
its own, runs it, and says how much it takes there; writes a bill of materials and judges its licences;
compares version, CHANGELOG and CITATION. Prints each finding, and exits with 1 if one of them is wrong.
What is built stays in the folder `--out`. Set OTOLITH_ADDRESS to the repository's address, so that the
README of the package has links.
"""

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import venv
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from footprint import footprint, table
from licences import PERMISSIVE, refused

ROOT: Final = Path(__file__).resolve().parents[1]
LARGEST: Final = 2_000_000  # bytes of a wheel
_SECTION: Final = re.compile(
    r"^## (?:(?P<version>\d+\.\d+\.\d+)(?: - (?P<date>\d{4}-\d\d-\d\d))?|Unreleased)", re.MULTILINE
)


def main() -> None:
    """Check everything, also after a finding."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    out = parser.parse_args().out.resolve()
    with tempfile.TemporaryDirectory(prefix="otolith-release-") as name:
        findings = list(check(Path(name), out))
    for finding in findings:
        print(f"WRONG: {finding}")
    print(f"\n{len(findings)} findings")
    sys.exit(1 if findings else 0)


def check(work: Path, out: Path) -> Iterator[str]:
    """Print what is found, and yield a sentence for each thing that is wrong."""
    if run("git", "-C", str(ROOT), "status", "--porcelain", "--untracked-files=no"):
        print("note: changes that are not committed are not part of what is built")
    first, second = (built(work / name) for name in ("one", "another"))
    print("SHA-256 of two builds:")
    for name in sorted({*first, *second}):
        hashes = [digest(build[name]) if name in build else "not built" for build in (first, second)]
        print(f"  {name}\n    {hashes[0]}\n    {hashes[1]}")
        if len(set(hashes)) > 1:
            yield f"two builds of {name} differ"
    wheel = next(path for name, path in first.items() if re.match(r"otolith-.*\.whl", name))
    print(f"\nwheel: {wheel.stat().st_size:,} bytes, at most {LARGEST:,}")
    if wheel.stat().st_size > LARGEST:
        yield f"the wheel has {wheel.stat().st_size:,} bytes, more than {LARGEST:,}"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    kept = [str(shutil.copy(path, out)) for path in first.values()]
    run(sys.executable, "-m", "twine", "check", "--strict", *kept)
    print("\nthe packages' pages can be shown (twine check --strict)")
    python = installed(wheel, work / "environment")
    sizes = footprint(Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))")))
    print(f"\ninstalled:\n{table(sizes)}")
    bill = out / f"{wheel.name.split('-py3')[0]}.cdx.json"
    write_bill(python, wheel, bill)
    content = json.loads(bill.read_text(encoding="utf-8"))
    wrong = refused(content, PERMISSIVE)
    print(f"\nbill of materials: {bill}")
    print(f"licences: {len(content['components'])} packages, {len(wrong)} not allowed")
    yield from (f"the licence of {name} is not allowed: {licence}" for name, licence in wrong.items())
    yield from versions(wheel.name.split("-")[1], (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))


def built(folder: Path) -> dict[str, Path]:
    """Build both distributions from a clone of this commit; the files by their names."""
    clone, out = folder / "clone", folder / "out"
    run("git", "clone", "--quiet", "--no-hardlinks", str(ROOT), str(clone))
    run("git", "-C", str(clone), "checkout", "--quiet", run("git", "-C", str(ROOT), "rev-parse", "HEAD"))
    for one in (clone, clone / "thesis"):
        run(sys.executable, "-m", "build", "--outdir", str(out), str(one))
    return {path.name: path for path in out.iterdir() if path.is_file()}


def installed(wheel: Path, folder: Path) -> str:
    """Install a wheel into a new environment and cue a step with it; the environment's Python."""
    venv.create(folder, with_pip=True)
    python = str(folder / ("Scripts" if os.name == "nt" else "bin") / "python")
    run(python, "-m", "pip", "install", "--quiet", "--no-compile", "--disable-pip-version-check", str(wheel))
    begin = "import sys; from otolith.cli import main; main(sys.argv[1:])"
    run(python, "-I", "-c", begin, "run", "step-1", "--cueing", "classical", "--out", str(folder / "run"))
    print(f"\n{run(python, '-I', '-c', begin, '--version')} runs from its wheel")
    return python


def write_bill(python: str, wheel: Path, bill: Path) -> None:
    """Write what is installed beside Otolith as a CycloneDX bill of materials, without times and chance."""
    words = [
        "environment",
        python,
        "--of",
        "JSON",
        "--output-reproducible",
        "--pyproject",
        str(ROOT / "pyproject.toml"),
    ]
    run(sys.executable, "-m", "cyclonedx_py", *words, "--output-file", str(bill))
    content = json.loads(bill.read_text(encoding="utf-8"))
    content["metadata"]["component"]["version"] = wheel.name.split("-")[1]
    ours = {"otolith", "pip", "setuptools"}  # the root itself, and what every environment has
    content["components"] = [one for one in content["components"] if one["name"] not in ours]
    kept = {one["bom-ref"] for one in content["components"]} | {content["metadata"]["component"]["bom-ref"]}
    content["dependencies"] = [one for one in content["dependencies"] if one["ref"] in kept]
    for one in content["dependencies"]:
        one["dependsOn"] = [ref for ref in one.get("dependsOn", []) if ref in kept]
    bill.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def versions(version: str, changelog: str) -> Iterator[str]:
    """Yield what is wrong with the version: CHANGELOG, CITATION.cff and the tag must tell the same one."""
    newest = _SECTION.search(changelog)
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    told, dated = (newest["version"], newest["date"]) if newest else (None, None)
    said = cited[1] if cited else None
    print(f"\nversion {version}; CHANGELOG.md: {told} of {dated}; CITATION.cff: {said}")
    if "dev" in version or "+" in version:
        print("this commit has no tag: it is no release")
        return
    if told != version or dated is None:
        yield f"CHANGELOG.md does not begin with the section '## {version} - DATE'"
    if said != version:
        yield f"CITATION.cff does not say version {version}"


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def run(*command: str) -> str:
    """Run a command and return what it printed; what it said besides is shown if it fails."""
    clean = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONHOME")}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=clean)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout.strip()


if __name__ == "__main__":
    main()

#!/bin/sh
# dask-kubernetes 2026.3.0 with distributed 2026.8.0: the cluster that it describes starts commands that no longer exist.
#
# make_cluster_spec, and KubeCluster with its defaults, start the containers by `dask-scheduler` and `dask-worker`. Both are
# gone from the distributed that pip chooses for it; `dask scheduler` and `dask worker` took their place. In an image with this
# distributed neither container starts. worker_command mends the workers; for the scheduler there is no such argument, so
# its "args" have to be replaced in the specification, which KubeCluster takes as custom_cluster_spec.
#
# Run by hand. Exits 0 while this holds, 1 once it does not.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet "dask-kubernetes==2026.3.0" "dask==2026.8.0" "distributed==2026.8.0"
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

from dask_kubernetes.operator import make_cluster_spec

print("dask-kubernetes", version("dask-kubernetes"), "distributed", version("distributed"))
spec = make_cluster_spec(name="one", image="registry.example.org/one:1", n_workers=2)["spec"]
commands = [spec[role]["spec"]["containers"][0]["args"][0] for role in ("scheduler", "worker")]
scripts = Path(sys.executable).parent
missing = [command for command in commands if not (scripts / command).exists()]
print("started by the containers:", *commands)
print("of these not installed:", *missing)
known = []
for command in ("scheduler", "worker"):
    done = subprocess.run([scripts / "dask", command, "--help"], capture_output=True)
    known += [f"dask {command}"] if done.returncode == 0 else []
print("installed instead:", *known, sep="  ")
sys.exit(0 if missing == commands and len(known) == 2 else 1)
PYTHON

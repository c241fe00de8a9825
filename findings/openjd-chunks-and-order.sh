#!/usr/bin/env bash
# openjd-cli 0.8.0 with openjd-model 0.13.0 (PyPI): chunks of a task parameter CHUNK[INT].
#
# What a farm's frame or crop script is handed as the text of its chunk.
# Guess for frames 1-10, chunks of 3, CONTIGUOUS: 1-3, 4-6, 7-9, 10.            Seen: 1-3, 4-5, 6-8, 9-10: the count
#        of chunks comes from the size, then they are evened out, so that most chunks are not of the size asked for.
# Guess for the odd frames 1-9:2, chunks of 3, NONCONTIGUOUS: "1,3,5" and "7,9". Seen: "1-5:2" and "7,9": whoever
#        splits at commas sees only one number in the first.
# Guess for 10-1:-4 (10, 6, 2), NONCONTIGUOUS: "10,6,2".                        Seen: "2-10:4": the order is turned
#        round. CONTIGUOUS keeps it: "10-10", "6-6", "2-2".
. "$(dirname "$0")/lib.sh"
python_with openjd-cli==0.8.0 openjd-model==0.13.0 openjd-sessions==0.13.0
cd "$work"
"$python" - "$work/venv/bin/openjd" <<'PY'
import json, re, subprocess, sys
from pathlib import Path
from verdict import verdict

def chunks(frames, constraint):
    template = {
        "specificationVersion": "jobtemplate-2023-09", "extensions": ["TASK_CHUNKING"], "name": "job",
        "steps": [{
            "name": "Bake",
            "parameterSpace": {"taskParameterDefinitions": [{
                "name": "Frame", "type": "CHUNK[INT]", "range": frames,
                "chunks": {"defaultTaskCount": 3, "rangeConstraint": constraint},
            }]},
            "script": {"actions": {"onRun": {"command": "echo", "args": ["chunk={{Task.Param.Frame}}="]}}},
        }],
    }
    Path("job.json").write_text(json.dumps(template))
    run = subprocess.run([sys.argv[1], "run", "job.json", "--extensions", "TASK_CHUNKING"], capture_output=True, text=True, check=True)
    return re.findall(r"\tchunk=(.*)=", run.stdout)

verdict("1-10 by 3, CONTIGUOUS", "1-3, 4-6, 7-9, 10", chunks("1-10", "CONTIGUOUS"), ["1-3", "4-5", "6-8", "9-10"])
verdict("1-9:2 by 3, NONCONTIGUOUS", "1,3,5 and 7,9", chunks("1-9:2", "NONCONTIGUOUS"), ["1-5:2", "7,9"])
verdict("10-1:-4 by 3, NONCONTIGUOUS", "10,6,2", chunks("10-1:-4", "NONCONTIGUOUS"), ["2-10:4"])
verdict("10-1:-4 by 3, CONTIGUOUS", "10, 6, 2", chunks("10-1:-4", "CONTIGUOUS"), ["10-10", "6-6", "2-2"])
PY

"""Makes the pictures of docs/guide/python.md by running its blocks.

guide_pictures.py [FOLDER]: into docs/images unless another folder is named.
"""

import os
import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "tests"))
from test_docs import GUIDE, ROOT, run

target = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "docs/images").resolve()
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    run(GUIDE)
    for path in sorted(Path(folder).glob("*.png")):
        shutil.copy(path, target / path.name)
        print(target / path.name, path.stat().st_size, "bytes")
    os.chdir(ROOT)

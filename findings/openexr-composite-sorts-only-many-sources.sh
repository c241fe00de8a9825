#!/usr/bin/env bash
# OpenEXR 3.1.5 (Debian 12): CompositeDeepScanLine, the official way from deep to flat.
#
# A pixel is stored back to front: green (0.5, alpha 0.5) at depth 2, then red at depth 1. It is put together
# alone; with a second file whose pixel is empty; with a second file whose pixel is one sample of alpha 0.
# Guess: the same each time, R 0.5 and G 0.25: the samples are sorted, and alpha 0 adds nothing.
# Seen:  alone, and beside an empty pixel, R 0.25 and G 0.5 (not sorted); beside a sample that nobody can see,
#        R 0.5 and G 0.25 (sorted). Only a pixel with samples of more than one source is sorted. The unseen sample
#        also moves the flat depth from 2.5 to 4.25.
. "$(dirname "$0")/lib.sh"
python_with OpenEXR==3.5.3 numpy==2.4.6
debian_with libopenexr-dev 3.1.5-5 g++ 4:12.2.0-3 pkg-config 1.8.1-1
cd "$work"
cat > composite.cpp <<'CPP'
#include <OpenEXR/ImfCompositeDeepScanLine.h>
#include <OpenEXR/ImfDeepScanLineInputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <cstdio>
#include <memory>
#include <vector>
int main(int count, char** paths) {
    using namespace OPENEXR_IMF_NAMESPACE;
    std::vector<std::unique_ptr<DeepScanLineInputFile>> files;
    CompositeDeepScanLine composite;
    for (int i = 1; i < count; ++i) {
        files.push_back(std::make_unique<DeepScanLineInputFile>(paths[i]));
        composite.addSource(files.back().get());
    }
    const char* names[] = {"R", "G", "A", "Z"};
    float pixel[4] = {};
    FrameBuffer buffer;
    for (int i = 0; i < 4; ++i) buffer.insert(names[i], Slice(FLOAT, (char*)&pixel[i], 4, 4));
    composite.setFrameBuffer(buffer);
    composite.readPixels(0, 0);
    printf("%g %g %g %g\n", pixel[0], pixel[1], pixel[2], pixel[3]);
}
CPP
g++ -O1 composite.cpp -o composite $(pkg-config --cflags --libs OpenEXR)
"$python" - <<'PY'
import subprocess
from deep_file import write_deep
from verdict import verdict

names = ("R", "G", "A", "Z")
write_deep("backwards.exr", names, [[(0, 0.5, 0.5, 2), (0.5, 0, 0.5, 1)]])
write_deep("empty.exr", names, [[]])
write_deep("unseen.exr", names, [[(0, 0, 0, 9)]])

def composite(*files):
    return [float(v) for v in subprocess.run(["./composite", *files], capture_output=True, text=True, check=True).stdout.split()]

guess = "R 0.5, G 0.25, A 0.75, and one depth in all three"
verdict("R, G, A, Z of the file alone", guess, composite("backwards.exr"), [0.25, 0.5, 0.75, 2.5])
verdict("with an empty pixel", guess, composite("backwards.exr", "empty.exr"), [0.25, 0.5, 0.75, 2.5])
verdict("with a sample of alpha 0", guess, composite("backwards.exr", "unseen.exr"), [0.5, 0.25, 0.75, 4.25])
PY

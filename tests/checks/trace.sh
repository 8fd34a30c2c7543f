#!/bin/sh
# usage: trace.sh PROGRAM
# What --trace writes, read by a parser that is not ours: every event has its fields, spans of one line lie beside or within
# each other, a tick has the callbacks and stages that it ran, and what is within a span takes no longer than the span.
set -eu

program=$1
root=$(cd -- "$(dirname -- "$0")/../.." && pwd)
command -v python3 >/dev/null || { echo "no python3" && exit 77; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
cd "$root"

cat >"$out/look.py" <<'END'
import json, sys

path, *wanted = sys.argv[1:]
data = json.load(open(path))
spans = [e for e in data["traceEvents"] if e["ph"] == "X"]
assert spans and all(isinstance(e["name"], str) and e["ts"] >= 0 and e["dur"] >= 0 and e["pid"] == 1 for e in spans)
frames = [e["ts"] + e["dur"] for e in spans if e["name"] == "frame"]
spans = [e for e in spans if not frames or e["ts"] < max(frames)]  # without those of a frame that was under way
slack = 0.002  # microseconds: times are rounded to nanoseconds
for track in {e["tid"] for e in spans}:
    open_spans = []
    for e in sorted((e for e in spans if e["tid"] == track), key=lambda e: (e["ts"], -e["dur"])):
        end = e["ts"] + e["dur"]
        while open_spans and open_spans[-1]["end"] <= e["ts"] + slack: open_spans.pop()
        if open_spans:
            parent = open_spans[-1]
            assert end <= parent["end"] + slack, (parent["name"], e)
            parent["inside"] += e["dur"]
            assert parent["inside"] <= parent["dur"] + 1, (parent["name"], parent["inside"], parent["dur"])
            e["parent"] = parent["name"]
        e["end"], e["inside"] = end, 0
        open_spans.append(e)
for want in wanted:
    name, _, rest = want.partition("=")
    least, _, parent = rest.partition("@")
    found = [e for e in spans if e["name"] == name]
    assert len(found) >= int(least or 1), (want, len(found))
    assert not parent or all(e.get("parent") == parent for e in found), (want, {e.get("parent") for e in found})
print(f"{len(spans)} spans in {path.rsplit('/', 1)[-1]}, all as they should be")
END

"$program" play marble --headless --replay games/marble/demo.rec --ticks 90 --every-frame --trace "$out/play.json" --sound "$out/a.wav" \
    >/dev/null
python3 "$out/look.py" "$out/play.json" frame=90 tick=90@frame daft.update=90@tick simulation=90@tick solve=60@simulation \
    picture=90@frame daft.draw=90@frame sound=90@tick present=90@frame visibility=90
"$program" render assets/scenes/hall.scene --size 160x90 --repeat 2 -o "$out/a.png" --trace "$out/render.json" 2>/dev/null
python3 "$out/look.py" "$out/render.json" load=1 picture=2 write=1

# Ended early, and failed: the file is whole all the same.
: >"$out/early.txt"
"$program" play marble --headless --ticks 100000000 --hash --trace "$out/early.json" >"$out/early.txt" 2>&1 &
while kill -0 $! 2>/dev/null && ! grep -q '^tick 120 ' "$out/early.txt"; do sleep 0.05; done
kill -TERM $!
wait $! || [ $? -eq 143 ]
python3 "$out/look.py" "$out/early.json" tick=100@frame
"$program" play tests/games/broken_update --headless --trace "$out/failed.json" >/dev/null 2>&1 && exit 1
python3 "$out/look.py" "$out/failed.json" tick=9@frame
"$program" play marble --headless --ticks 3 --trace /nowhere/a.json >"$out/log" 2>&1 && exit 1
grep -q '/nowhere/a.json' "$out/log"

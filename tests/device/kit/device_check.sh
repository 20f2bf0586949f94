#!/usr/bin/env bash
# Finds what of Coppice's frames hangs a GPU, within seven minutes. Needs itself and bundle.tgz, which `bundle` makes, in one folder of a machine
# with a Vulkan driver, and nothing else: libraries come from the bundle where the machine has none.
#
#   bash device_check.sh [SECTION...]     micro, hardware, raster, tests, and old where the bundle has another state; all by default
#
#   OUT=FOLDER      for its log and dumps
#   LIMIT=SECONDS   of a step, 45 by default; WAIT=SECONDS after which the probe calls a wait a hang, 8 by default: a software driver needs more
#
# Exit codes: 0 every step is right, 1 one is not, 2 no device. A hang may leave the GPU unfit: the script tells, stops and exits with 3. Then run
# the sections that are left on a fresh machine.
set -u
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
work="$(mktemp -d)"
out="${OUT:-$work/out}"
mkdir -p "$out"
exec > >(tee "$out/device_check.log") 2>&1
tar xzf "$here/bundle.tgz" -C "$work" || exit 2
b="$work/bundle"
sections="${*:-micro hardware raster tests}"
[ $# -gt 0 ] || [ ! -e "$b/bin/forest_old" ] || sections="micro old hardware raster tests"
export LD_LIBRARY_PATH="$b/lib:${LD_LIBRARY_PATH:-}"
ldconfig -p 2>/dev/null | grep -q 'libstdc++.so.6' || export LD_LIBRARY_PATH="$LD_LIBRARY_PATH:$b/libstd"
ldconfig -p 2>/dev/null | grep -q 'libvulkan.so.1' && rm -f "$b/lib/libvulkan.so.1"
export VK_LAYER_PATH="$b/layer"
icd=/usr/local/nvidia/share/vulkan/icd.d/nvidia_icd.json
[ -n "${VK_DRIVER_FILES:-}" ] || { [ -f "$icd" ] && export VK_DRIVER_FILES="$icd" VK_ICD_FILENAMES="$icd"; }
# A cache of shaders that an earlier, killed run left half written must not count.
export __GL_SHADER_DISK_CACHE_PATH="$work" HOME="$work"
limit="${LIMIT:-45}"
unfit=0
declare -A result

xids() { dmesg 2>/dev/null | grep -c 'NVRM: Xid'; }

# run NAME SECONDS COMMAND...: its exit code; 124 after SECONDS, 137 where it cannot even be killed
run() {
  local name="$1" seconds="$2" before now pid rc said
  shift 2
  before="$(xids)"
  now="$SECONDS"
  setsid "$@" > "$work/$name.log" 2>&1 &
  pid=$!
  for ((i = 0; i < seconds * 5; ++i)); do kill -0 "$pid" 2>/dev/null || break; sleep 0.2; done
  if kill -0 "$pid" 2>/dev/null; then
    kill -KILL -- "-$pid" 2>/dev/null
    for ((i = 0; i < 40; ++i)); do kill -0 "$pid" 2>/dev/null || break; sleep 0.2; done
    rc=124
    kill -0 "$pid" 2>/dev/null && rc=137
  else
    wait "$pid"
    rc=$?
  fi
  result[$name]=$rc
  case "$rc" in
    0) said=ok ;;
    86) said='HANG (the probe says where)' ;;
    87) said='a pipeline does not end to compile' ;;
    124) said='HANG, killed' ;;
    137) said='HANG, cannot be killed' ;;
    *) said=failed ;;
  esac
  printf '%-32s rc %3s  %3ss  %s\n' "$name" "$rc" "$((SECONDS - now))" "$said"
  [ "$rc" = 0 ] || grep -avE 'probe: (compute|graphics|submission|address|memory type)' "$work/$name.log" | tail -n 30 | sed 's/^/    /'
  grep -ahE 'pipeline.*: 0, ([5-9]|[0-9]{2,})\.[0-9]+ s' "$work/$name.log" | sed 's/^/    slow: /' | head -n 5
  [ "$(xids)" = "$before" ] || dmesg 2>/dev/null | grep 'NVRM: Xid' | tail -n $(($(xids) - before))
  return "$rc"
}

# Whether the GPU still does the plainest things.
health() {
  for test in empty loop_direct_64 draw_triangle; do
    run "health_$1_$test" 12 "$b/bin/gpu_micro" "$test" && continue
    echo "UNFIT after $1: what follows would say nothing. Go on with the other sections on a fresh machine"
    unfit=1
    return 1
  done
}

step() { # NAME SECONDS COMMAND...
  [ "$unfit" = 0 ] || return 1
  run "$@" && return 0
  [ "${result[$1]}" = 1 ] || [ "${result[$1]}" = 127 ] || health "$1"
  return 1
}

probed="VK_INSTANCE_LAYERS=VK_LAYER_COPPICE_probe PROBE_MARKS=1 PROBE_ARGS=1 PROBE_LOG=1 PROBE_TIMEOUT=${WAIT:-8} PROBE_COMPILE_TIMEOUT=20"
small="--headless --count 1 --frames 1 --size 64x64"
forest="$b/bin/forest $small --plants $b/plants/corylus.coppice"
old="$b/bin/forest_old $small --plants $b/plants/old.coppice"
probe() { step "$1" "$limit" env $probed "${@:2}"; } # NAME COMMAND...

echo "state $(cat "$b/state"), $(uname -r)"
nvidia-smi -L 2>/dev/null
[ "$(xids)" = 0 ] || echo "There are Xids before the first step: is this machine fresh?"
run start 20 "$b/bin/gpu_micro" empty || { cat "$work/start.log"; echo "no Vulkan device that can be used"; exit 2; }
head -n 1 "$work/start.log"

for section in $sections; do
  [ "$unfit" = 0 ] || break
  echo "== $section ($SECONDS s)"
  case "$section" in
    micro) for test in $("$b/bin/gpu_micro"); do step "micro_$test" 12 "$b/bin/gpu_micro" "$test"; done ;;
    old)
      probe old_hardware $old --path hardware
      probe old_raster $old
      step old_raster_plain "$limit" $old ;;
    hardware)
      first="--path hardware --renderer forward"
      probe hardware_alone $forest $first --no-shadows --no-taa
      probe hardware_shadows $forest $first --no-taa
      probe hardware_all $forest --path hardware
      step hardware_plain "$limit" $forest --path hardware ;;
    raster)
      first="--path compute --renderer forward --no-shadows --no-taa"
      if ! probe raster_alone $forest $first && [ "$unfit" = 0 ]; then
        label="$(grep -ah '>>>' "$work/raster_alone.log" | head -n 1 | awk '{print $5}' | sed 's/\[.*//; s/.*+//')"
        [ -z "$label" ] || probe "without_$label" PROBE_SKIP="$label" $forest $first
        probe serial PROBE_SERIAL=1 $forest $first
        probe few_lanes PROBE_CPU=1 $forest $first
        probe two_passes PROBE_NO_INT64=1 $forest $first
        for skip in leaf_raster,big_leaves,leaf_splats leaf_expand cull_raster leaf_tiles resolve; do
          probe "without_$skip" PROBE_SKIP="$skip" $forest $first
        done
      fi
      probe raster_all $forest
      step raster_plain "$limit" $forest ;;
    tests)
      filter='RendererTest.*:SelectionTest.*:LeafRasterTest.LeavesOfEightPixelsAreTheHardwares'
      step tests_validated 120 "$b/bin/gpu_tests" --gtest_brief=1 --gtest_filter="$filter" ;;
    *) echo "no section $section"; result[$section]=1 ;;
  esac
done

echo "== summary ($SECONDS s)"
for name in "${!result[@]}"; do printf '%3s %s\n' "${result[$name]}" "$name"; done | grep -v ' health_' | sort -k2
wrong=0
for name in "${!result[@]}"; do [ "${result[$name]}" = 0 ] || wrong=1; done
tar czf "$out/logs.tgz" -C "$work" $(cd "$work" && ls ./*.log) 2>/dev/null
dmesg 2>/dev/null | grep -E 'NVRM|Xid' | tail -n 40 > "$out/dmesg.txt"
[ "$unfit" = 0 ] || exit 3
exit "$wrong"

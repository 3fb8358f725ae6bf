# shellcheck shell=bash
# To be sourced after setup.sh, by tools/test: builds the fuzzers and runs them.
# shellcheck disable=SC2154  # psim_root and psim_packages are of setup.sh

psim_fuzz_inputs=(scene rube state details saved recording world)

# clang and its libFuzzer, which is a package of its own where clang only recommends it.
psim_install_fuzzer() {
  psim_install "${psim_packages[@]}" clang || return 1
  local runtime
  runtime="$(clang++ -print-file-name="libclang_rt.fuzzer-$(uname -m).a")"
  [[ -f $runtime ]] ||
    psim_install "libclang-rt-$(clang++ -dumpversion | cut -d. -f1)-dev"
}

# psim_fuzz_one INPUT SECONDS: one fuzzer over the corpus and fresh inputs; those that reach new code are kept in
# build/fuzz/corpus for the next run. An input may take PSIM_FUZZ_TIMEOUT seconds (20): more beside other work. 1 if it
# found a fault: it says where the input lies. Without -entropic=0, libFuzzer takes longer to count how rare the code
# is that an input of the world reaches (some 30,000 places) than the input takes.
psim_fuzz_one() {
  local input="$1" share="$2" home="$psim_root/build/fuzz" dictionary="" longest=4096 log status=0
  case $input in
    scene | rube) dictionary="-dict=$psim_root/tests/fuzz/$input.dict" ;;
    state | details) dictionary="-dict=$psim_root/tests/fuzz/csv.dict" ;;
    saved | recording) longest=32768 ;;
  esac
  mkdir -p "$home/corpus/$input"
  log="$home/fuzz_$input.log"
  # shellcheck disable=SC2086  # no dictionary, no word
  UBSAN_OPTIONS=print_stacktrace=1 "$home/fuzz_$input" -max_total_time="$share" -timeout="${PSIM_FUZZ_TIMEOUT:-20}" \
    -rss_limit_mb=2048 -seed="${PSIM_FUZZ_SEED:-0}" -max_len="$longest" -print_final_stats=1 -artifact_prefix="$home/findings/$input-" \
    -entropic=0 \
    $dictionary "$home/corpus/$input" "$psim_root/tests/fuzz/corpus/$input" \
    >"$log" 2>&1 || status=$?
  if ((status == 0)); then
    echo "fuzz_$input: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs in $share s, no finding"
    return 0
  fi
  grep -E '^(fault:|SUMMARY|ERROR|==.*ERROR|.*PSIM_ASSERT)|Test unit written to' "$log" >&2
  psim_say "fuzz_$input found a fault: build/fuzz/fuzz_$input INPUT shows it again, its talk is in $log"
  return 1
}

# psim_fuzz SECONDS: every fuzzer for its share of the time, the calls of the world for half of it, at the same time as
# the others where there are cores. 1 if one found a fault.
psim_fuzz() {
  local seconds="$1" input share found=0 world home="$psim_root/build/fuzz"
  psim_install_fuzzer || return 1
  psim_build fuzz fuzzers || return 1
  mkdir -p "$home/findings"
  psim_fuzz_one world $((seconds > 1 ? seconds / 2 : 1)) &
  world=$!
  (($(nproc) > 1)) || { wait "$world" || found=1; world=""; }
  share=$((seconds > 10 ? seconds / 10 : 1))
  for input in "${psim_fuzz_inputs[@]}"; do
    [[ $input == world ]] || psim_fuzz_one "$input" "$share" || found=$((found + 1))
  done
  [[ -z $world ]] || wait "$world" || found=$((found + 1))
  echo "${#psim_fuzz_inputs[@]} fuzzers, $found with a finding"
  ((found == 0))
}

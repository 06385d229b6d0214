# `./dev guard`, what CI runs after the tests: the checks that can be had in 20 minutes on two cores with the compiler's
# cache empty. So it builds only what it runs, in one build per kind of watching.
# shellcheck shell=bash
source tools/checks.sh

# What runs under the sanitizers: a test program, and which of its tests. All take seconds though watched, and their
# programs are quick to build; together they go through readers, predicates, narrow phase, hierarchy and queries.
guarded_by_address=(
  'test_base *'
  'test_io *'
  'test_solver *'
)
guarded_by_thread=(
  'test_base Parallel*:PerThread*:ThreadLimit*'
  'test_arithmetic Modes*'
  'test_bvh *'
  'test_solver *'
)
guard_fuzz_seconds=10
guard_search_seconds=60
guard_tidy_sources=20  # some five minutes; `./dev lint` checks all

# The commit that changes are counted from: where this branch left origin/main, else the one before. None in a clone
# without a past.
base_of_changes() {
  local base
  base=$(git merge-base HEAD origin/main 2>/dev/null) || base=''
  [[ -n $base && $base != "$(git rev-parse HEAD)" ]] || base=$(git rev-parse --verify --quiet 'HEAD^') || return 1
  echo "$base"
}

# Sources that differ from that commit, or whose header does: those of the library and the program first, and of these those
# with the most changed lines.
changed_sources() {
  { git diff --numstat --no-renames "$1" && git ls-files --others --exclude-standard | sed 's,^,0\t0\t,'; } |
    awk -F '\t' '{ sub(/\.h$/, ".cpp", $3); lines[$3] += $1 + $2 }
      END { for (source in lines) print (source ~ /^(src|apps)\//) "\t" lines[source] "\t" source }' |
    sort -k 1,1nr -k 2,2nr -k 3 | cut -f 3 | { grep -Fxf <(tidy_sources) || (($? == 1)); }
}

guard_tidy() {
  local base changed files
  base=$(base_of_changes) || {
    echo "no commit before this one is here"
    return "$skipped"
  }
  changed=$(changed_sources "$base")
  if [[ -z $changed ]]; then
    echo "no source differs from $(git log -1 --format=%h "$base")"
    return "$skipped"
  fi
  mapfile -t files <<<"$changed"
  prepare_tidy
  run_clang_tidy "${files[@]:0:guard_tidy_sources}"
  if ((${#files[@]} <= guard_tidy_sources)); then
    echo "${#files[@]} sources, all that differ from $(git log -1 --format=%h "$base")"
  else
    echo "$guard_tidy_sources of ${#files[@]} sources that differ from $(git log -1 --format=%h "$base"), those with the" \
      "most changed lines; ./dev lint checks all"
  fi
}

# run_guarded PRESET 'PROGRAM FILTER'...
run_guarded() {
  local preset=$1 entry programs=()
  shift
  for entry in "$@"; do programs+=("${entry%% *}"); done
  configure "$preset"
  build_preset "$preset" "${programs[@]}"
  for entry in "$@"; do
    require_tests "build-$preset/${entry%% *}" "${entry#* }"
    timeout 600 "build-$preset/${entry%% *}" --gtest_filter="${entry#* }" --gtest_brief=1
  done
}

# In the fuzz targets' build: its library is watched for both already.
guard_address() {
  export ASAN_OPTIONS=detect_stack_use_after_return=1 UBSAN_OPTIONS=print_stacktrace=1
  run_guarded fuzz "${guarded_by_address[@]}"
}

guard_thread() {
  export TSAN_OPTIONS=$tsan_options
  run_guarded tsan "${guarded_by_thread[@]}"
}

guard_search() {
  configure release -DFOLDPROOF_TESTS=ON
  build_preset release adversary
  build/adversary --seed "$RANDOM" --seconds "$guard_search_seconds"
}

guard_format() { check_format; }
guard_layers() { tools/check_layers; }
guard_fuzz() { do_fuzz "$guard_fuzz_seconds"; }

guard_checks=(format layers tidy thread address fuzz search)

# do_guard [CHECK...]
do_guard() {
  local name chosen=("$@")
  (($#)) || chosen=("${guard_checks[@]}")
  for name in "${chosen[@]}"; do
    [[ " ${guard_checks[*]} " == *" $name "* ]] || die "guard has no check '$name'; it has: ${guard_checks[*]}"
  done
  need lib test python bench fuzz lint
  trap 'stop_checks; echo; print_checks; exit 130' INT TERM
  say "guarding; what each check prints is in out/checks"
  for name in "${chosen[@]}"; do run_check "$name" "guard_$name"; done
  say "guard"
  print_checks
  ((checks_failed == 0)) || die "$checks_failed of ${#check_names[@]} checks failed"
}

# `./dev all`, for a night without anybody: every check at full length, whatever fails, and docs/quality.md says what came
# of it. The table is written anew after each check, so that there is one however this ends. Begun again, on another machine
# too if it has the page, it runs what has not passed and what reads files that have changed since it passed.
# shellcheck shell=bash
source tools/checks.sh

# Checks of everything go by groups of modules, so that a change of the program does not check the query again.
all_checks=(test proofs)
for name in lint address thread; do all_checks+=("${name}_query" "${name}_models" "${name}_rest"); done
all_checks+=(fuzz_query fuzz_models fuzz_gltf search floats frames mutants bench arm64 s390x compilers)

query_modules='base mesh ccd bvh certificate check solver statistics reduced'
query_tests="$query_modules arithmetic allocation oracle search adversary"
model_modules='io keypoints learned model'
query_fuzz_targets='ccd query'

# in_group GROUP FORMAT: a regular expression from the modules of a group of tests; FORMAT has %s in their place.
in_group() {
  local modules=$query_tests
  [[ $1 == query ]] || modules=$model_modules
  printf "$2" "${modules// /|}"
}

# sources_of MODULE...
sources_of() {
  local module
  for module in "$@"; do echo "src/$module" "include/foldproof/$module.h"; done | xargs
}

# tests_of MODULE...
tests_of() {
  printf 'tests/%s ' "$@"
}

# inputs_of CHECK: the files whose change makes it run again, as git's pathspecs. Tests of the query read motions and models,
# and check whole motions, but none is glTF. Tests of the program, the benchmarks, the page and sweep are not compiled for
# other machines.
inputs_of() {
  local built='CMakeLists.txt CMakePresets.json src/CMakeLists.txt' query models
  local not_compiled=':!tests/mutants :!tests/tools/*.py' no_test_programs=':!tests/*/*_test.cpp'
  local no_gltf=':!src/io/gltf* :!tests/io/gltf* :!tests/fuzz/fuzz_gltf.cpp :!tests/fuzz/corpus/gltf'
  local tests="$built tests/CMakeLists.txt tests/tools/fallback.cmake tests/base/callers.h"
  [[ $1 != lint_* ]] || tests+=' .clang-tidy tests/.clang-tidy'
  [[ $1 != thread_* ]] || tests+=' tools/tsan.supp'
  # shellcheck disable=SC2086  # lists of words
  query=$(sources_of $query_modules) models=$(sources_of $model_modules contacts report picture)
  # shellcheck disable=SC2086
  case $1 in
    lint_query | address_query | thread_query) echo "$tests $query $models $(tests_of $query_tests model) tests/io/support.h tests/report/needle.h $no_gltf" ;;
    lint_models | address_models | thread_models) echo "$tests $query $models $(tests_of $query_tests $model_modules report)" ;;
    fuzz_query) echo "$tests $query $models $(tests_of fuzz adversary oracle certificate solver) $no_test_programs $no_gltf" ;;
    fuzz_gltf) echo "$tests $query $models tests/fuzz/CMakeLists.txt tests/fuzz/file_target.h tests/fuzz/fuzz_gltf.cpp tests/fuzz/corpus/gltf" ;;
    fuzz_models) echo "$tests $query $models $(tests_of fuzz) $no_gltf $(printf ':!tests/fuzz/fuzz_%s.cpp ' $query_fuzz_targets)" ;;
    search) echo "$tests $query $models $(tests_of adversary search oracle certificate solver) $no_test_programs $no_gltf" ;;
    floats) echo "$tests $query include/foldproof/io.h $(tests_of arithmetic oracle) :!tests/oracle/judge.*" ;;
    proofs) echo "$built $query tools/proofs proofs docs/soundness.md" ;;
    frames) echo "$tests $query $models $(tests_of check contacts oracle bvh io model reduced report) :!tests/io/*_test.cpp $no_gltf" ;;
    mutants) echo "$tests $query $models tools/mutants $(tests_of mutants adversary search oracle bvh ccd check certificate solver allocation reduced arithmetic contacts model) tests/io/support.h tests/report/needle.h $no_gltf" ;;
    bench) echo 'CMakeLists.txt CMakePresets.json src include bench examples/solver tools/bench_tables' ;;
    arm64 | s390x) echo "dev $built cmake src include tests $not_compiled :!tests/apps :!tests/bench :!tests/page :!tests/sweep tools/cross_root" ;;
    compilers) echo "dev $built cmake src include apps bench examples tests $not_compiled tools/demo_poses.cpp" ;;
    test) echo '. :!docs/quality.md :!docs/benchmarks :!CHANGELOG.md :!CONTRIBUTING.md' ;;
    *) echo '. :!docs :!CHANGELOG.md :!CONTRIBUTING.md' ;;
  esac
}

# Programs with tests that take fewer frames of the real motions unless told otherwise.
programs_with_frames=(test_check test_contacts)

# What proofs assume of conversions, for every float there is and not only some.
all_floats() {
  local fallback status=0
  configure release -DFOLDPROOF_TESTS=ON
  build_preset release test_arithmetic test_arithmetic_fallback
  export FOLDPROOF_ALL_FLOATS=1
  build/test_arithmetic_fallback --gtest_brief=1 &
  fallback=$!
  build/test_arithmetic --gtest_brief=1 || status=1
  wait "$fallback" || status=1
  return "$status"
}

# Here a warning of GCC is an error in tests, examples and the Python module, too; `./dev compilers` builds the program alone
# with it.
all_test() {
  configure release -DCMAKE_COMPILE_WARNING_AS_ERROR=ON
  do_test
}
all_proofs() { do_proofs; }

# tidy_group GROUP: clang-tidy on the sources of a group; rest is what the others leave.
tidy_group() {
  local sources
  prepare_tidy
  case $1 in
    rest) mapfile -t sources < <(tidy_sources | grep -Ev "$(in_group query '^(src|tests)/(%s)/')|$(in_group models '^(src|tests)/(%s)/')") ;;
    *) mapfile -t sources < <(tidy_sources | grep -E "$(in_group "$1" '^(src|tests)/(%s)/')") ;;
  esac
  run_clang_tidy "${sources[@]}"
  echo "${#sources[@]} sources are clean"
}

all_lint_query() { tidy_group query; }
all_lint_models() { tidy_group models; }
all_lint_rest() {
  lint_basics
  tidy_group rest
}

# sanitize_group PRESET GROUP: the tests of a group.
sanitize_group() {
  case $2 in
    rest) sanitize "$1" . "$(in_group query '^(%s)(_fallback)?$')|$(in_group models '^(%s)$')" ;;
    *) sanitize "$1" "$(in_group "$2" '^(%s)(_fallback)?$')" ;;
  esac
}

all_address_query() { sanitize_group asan query; }
all_address_models() { sanitize_group asan models; }
all_address_rest() { sanitize_group asan rest; }
all_thread_query() { sanitize_group tsan query; }
all_thread_models() { sanitize_group tsan models; }
all_thread_rest() { sanitize_group tsan rest; }
# shellcheck disable=SC2086  # a list of words
all_fuzz_query() { do_fuzz $((60 * minutes)) $query_fuzz_targets; }
all_fuzz_models() {
  local targets
  mapfile -t targets < <(fuzz_targets | grep -vxF "${query_fuzz_targets// /$'\n'}"$'\n'gltf)
  do_fuzz $((60 * minutes)) "${targets[@]}"
}
all_fuzz_gltf() { do_fuzz $((60 * minutes)) gltf; }
all_search() { do_search $((360 * minutes)); }

all_frames() {
  local program status=0
  need_data
  configure release -DFOLDPROOF_TESTS=ON
  build_preset release "${programs_with_frames[@]}"
  for program in "${programs_with_frames[@]}"; do
    FOLDPROOF_ALL_FRAMES=1 "build/$program" --gtest_brief=1 || status=1
  done
  return "$status"
}

all_mutants() { do_mutants; }
all_bench() {
  do_bench --quick
  # Everybody must find the same candidates, and our collisions must be among them.
  build-bench/foldproof-bench --verify --scene bending-cylinder --steps 2 --peer-steps 2 --no-memory >/dev/null
  echo 'all candidates agree'
}
all_arm64() { do_arm64; }
all_s390x() { do_s390x; }
all_compilers() { do_compilers; }

# what_is NAME: for the table.
what_is() {
  local group='the rest'
  [[ $1 != *_query ]] || group='the query'
  [[ $1 != *_models ]] || group='files and models'
  case $1 in
    test) echo 'every test, those in Chromium and of WebAssembly too (`./dev test`)' ;;
    lint_rest) echo "layers, format, the page's types, pages of the headers; clang-tidy on the rest (\`./dev lint\`)" ;;
    lint_*) echo "clang-tidy on $group" ;;
    address_*) echo "tests of $group under the address and undefined-behavior sanitizers" ;;
    thread_*) echo "tests of $group under the thread sanitizer" ;;
    fuzz_query | fuzz_models) echo "fuzz targets of $group, $minutes min each" ;;
    fuzz_*) echo "fuzz target ${1##*_}" ;;
    search) echo "search for answers that are wrong, $((13 * minutes)) min of processor time (\`./dev search\`)" ;;
    search_answers*) echo 'small scenes of very different sizes, asked in every way' ;;
    search_*) echo 'meshes moved towards collisions that certificates exclude' ;;
    floats) echo 'what proofs assume of arithmetic, for every float' ;;
    proofs) echo 'the proofs of docs/soundness.md, read by Gappa and Coq' ;;
    frames) echo 'real motions, every frame' ;;
    mutants) echo 'planted defects that the guards must find' ;;
    bench) echo 'the benchmarks, `--quick`' ;;
    arm64) echo "the core's tests on 64-bit ARM, in QEMU (\`./dev arm64\`)" ;;
    s390x) echo "tests of motion files and of answers on a big-endian machine, in QEMU (\`./dev s390x\`)" ;;
    compilers) echo "warnings of GCC and Clang, and the library's tests built by each (\`./dev compilers\`)" ;;
  esac
}

# add_parts CHECK SECONDS: a row for each part of a check, from the lines that say what came of it.
add_parts() {
  local part result rest seconds
  while read -r part result rest; do
    seconds=$2
    [[ $part != certificates ]] || seconds=$(($2 / 6))
    [[ $result == clean, ]] && add_row "$1_$part" passed "$rest" "$seconds"
    [[ $result == FAILED\; ]] && add_row "$1_$part" FAILED "$rest" "$seconds"
  done <"out/checks/$1.log"
  return 0
}

machine() {
  local cpu memory
  cpu=$(awk -F ': ' '/^model name/ {print $2; exit}' /proc/cpuinfo)
  memory=$(awk '/^MemTotal/ {printf "%.0f", $2 / 1048576}' /proc/meminfo)
  echo "${cpu:-$(uname -m)}, $(nproc) cores, $memory GB, $(uname -sr)"
}

# write_quality STATE
write_quality() {
  local k result counts seconds commit
  {
    printf '# Quality\n\nWhat `./dev all` found. It writes this page. Each row has the commit that was\n'
    printf 'checked. From there to the commit named first, no file that the check reads has changed, unless in\n'
    printf 'lines that are comments.\n\n'
    printf '* Commit: %s\n* Last run: %s\n* Machine: %s\n* State: %s\n' "$all_commit" "$all_date" "$(machine)" "$1"
    printf '* Lengths: `--minutes %s`; in full it is `--minutes %s`\n' "$minutes" "$full_minutes"
    printf '\n| check | what | result | counts | min:s | commit |\n|---|---|---|---|---|---|\n'
    for k in "${!check_names[@]}"; do
      IFS='|' read -r result counts seconds commit <<<"${check_rows[k]}|"
      [[ $commit ]] && commit=${commit%|} || commit=$all_commit
      printf '| %s | %s | %s | %s | %s | %s |\n' "${check_names[k]}" "$(what_is "${check_names[k]}")" "$result" "$counts" "$(clock "$seconds")" "$commit"
    done
    for k in "${waiting[@]}"; do
      rows_of "$k" passed || rows_of "$k" FAILED || true
    done
  } >docs/quality.md.new
  mv docs/quality.md.new docs/quality.md
}

# read_quality: the rows of the page as it stands, if it is of this length and nothing is uncommitted.
read_quality() {
  local page=docs/quality.md
  [[ -z $all_changed ]] && grep -qs "^\* Lengths: \`--minutes $minutes\`" "$page" || return 0
  mapfile -t rows_before < <(grep '^| [a-z]' "$page")
}

# unchanged_since CHECK COMMIT: whether what it reads is as it was. For a check that only compiles and runs sources, lines
# that are a comment do not count.
unchanged_since() {
  local inputs ignore=()
  read -r -a inputs <<<"$(inputs_of "$1")"
  case $1 in
    address_* | thread_* | fuzz_* | search | floats | frames | arm64 | s390x | compilers) ignore=(-I '^ *//(|.*[^\\])$') ;;
  esac
  git diff --quiet "${ignore[@]}" "$2" HEAD -- "${inputs[@]}" 2>/dev/null
}

# rows_of CHECK RESULT: its rows and those of its parts, as the page has them, if it ended so and nothing that it reads has
# changed.
rows_of() {
  local rows commit
  rows=$(printf '%s\n' "${rows_before[@]}" | grep -E "^\| $1(_[^ ]*)? \|") && [[ ${rows%%$'\n'*} == "| $1 | "*" | $2 | "* ]] || return 1
  commit=$(sed -n -E '1 s/.* \| ([0-9a-f]+) \|$/\1/p' <<<"$rows")
  [[ $commit ]] && unchanged_since "$1" "$commit" && echo "$rows"
}

# take_rows CHECK RESULT: its rows, if they still hold.
take_rows() {
  local rows name result counts clock commit ended_at
  rows=$(rows_of "$1" "$2") || return 1
  while IFS='|' read -r _ name _ result counts clock commit _; do
    clock=${clock# } clock=${clock% } counts=${counts# } name=${name# } result=${result# } commit=${commit# }
    add_row "${name% }" "${result% }" "${counts% }" "$((10#${clock%:*} * 60 + 10#${clock#*:}))|${commit% }"
    ended_at=${commit% }
  done <<<"$rows"
  printf '%-12s %s before, at %s\n' "$1" "$2" "$ended_at"
}

read_all_arguments() {
  local name
  while (($#)); do
    case $1 in
      --minutes) minutes=${2:-} ;;
      --only) IFS=, read -r -a only <<<"${2:-}" ;;
      *) die "all takes --minutes N and --only CHECK,..., not '$1'" ;;
    esac
    shift $(($# > 1 ? 2 : 1))
  done
  [[ $minutes =~ ^[1-9][0-9]{0,3}$ ]] || die "--minutes takes a whole number from 1 on, not '$minutes'"
  ((${#only[@]})) || die "--only takes some of: ${all_checks[*]}"
  for name in "${only[@]}"; do
    [[ " ${all_checks[*]} " == *" $name "* ]] || die "there is no check '$name'; there are: ${all_checks[*]}"
  done
}

do_all() {
  full_minutes=10 minutes=10 only=("${all_checks[@]}")
  read_all_arguments "$@"
  all_commit=$(git log -1 --format=%h -- . ':!docs/quality.md') all_date=$(date -u '+%Y-%m-%d %H:%M UTC')
  all_changed=$(git status --porcelain -- . ':!docs/quality.md')
  [[ -z $all_changed ]] || all_commit+=' and changes'
  # Now, as nobody is there later to type a password.
  need lib test studio demo python package docs browser fuzz lint bench proofs web arm64 s390x compilers
  trap 'stop_checks; write_quality "stopped before its end"; echo; print_checks; exit 130' INT TERM
  say "everything, whatever fails; docs/quality.md says what came of it, out/checks what was printed"
  local name rows_before=() waiting=("${all_checks[@]}")
  read_quality
  for name in "${all_checks[@]}"; do
    waiting=("${waiting[@]:1}")
    if take_rows "$name" passed; then
      :
    elif [[ " ${only[*]} " == *" $name "* ]]; then
      run_check "$name" "all_$name"
      case $name in
        fuzz_query | fuzz_models) add_parts "$name" $((60 * minutes)) ;;
        search) add_parts search $((360 * minutes)) ;;
      esac
    elif take_rows "$name" FAILED; then
      checks_failed=$((checks_failed + 1))
    else
      add_row "$name" skipped 'not asked for' 0
    fi
    write_quality 'not yet at its end'
  done
  write_quality 'finished'
  say "docs/quality.md"
  print_checks
  ((checks_failed == 0)) || die "$checks_failed checks failed"
}

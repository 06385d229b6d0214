# `./dev all`, for a night without anybody: every check at full length, whatever fails, and docs/quality.md says what came
# of it. The table is written anew after each check, so that there is one however this ends. Begun again for the same commit,
# on another machine too if it has the page, it goes on with what has not passed.
# shellcheck shell=bash
source tools/checks.sh

all_checks=(test lint address thread fuzz search floats frames mutants bench)

# Programs with tests that take fewer frames of the real motions unless told otherwise.
programs_with_frames=(test_check test_keypoints test_learned test_oracle)

# What proofs assume of conversions, for every float there is and not only some.
all_floats() {
  configure release -DFOLDPROOF_TESTS=ON
  build_preset release test_arithmetic
  FOLDPROOF_ALL_FLOATS=1 build/test_arithmetic --gtest_brief=1
}

all_test() { do_test; }
all_lint() { do_lint; }
all_address() { sanitize_address; }
all_thread() { sanitize_thread; }
all_fuzz() { do_fuzz $((60 * minutes)); }
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
all_bench() { do_bench --quick; }

# what_is NAME: for the table.
what_is() {
  case $1 in
    test) echo 'every test, the page in Chromium too (`./dev test`)' ;;
    lint) echo 'layers, format, clang-tidy on every source (`./dev lint`)' ;;
    address) echo 'every test under the address and undefined-behaviour sanitizers' ;;
    thread) echo 'every test under the thread sanitizer' ;;
    fuzz) echo "every fuzz target, $minutes min each" ;;
    fuzz_*) echo "fuzz target ${1#fuzz_}" ;;
    search) echo "search for answers that are wrong, $((13 * minutes)) min of processor time (\`./dev search\`)" ;;
    search_answers*) echo 'small scenes of very different sizes, asked in every way' ;;
    search_*) echo 'meshes moved towards collisions that certificates exclude' ;;
    floats) echo 'what proofs assume of arithmetic, for every float' ;;
    frames) echo 'real motions, every frame' ;;
    mutants) echo 'planted defects that the guards must find' ;;
    bench) echo 'the benchmarks, `--quick`' ;;
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
  local k result counts seconds changed=''
  [[ -z $all_changed ]] || changed=', with changes that are not committed'
  {
    printf '# Quality\n\nWhat `./dev all` found. It writes this page.\n\n'
    printf '* Commit: %s%s\n* Begun: %s\n* Machine: %s\n* State: %s\n' "$all_commit" "$changed" "$all_date" "$(machine)" "$1"
    printf '* Lengths: `--minutes %s`; in full it is `--minutes %s`\n' "$minutes" "$full_minutes"
    printf '\n| check | what | result | counts | min:s |\n|---|---|---|---|---|\n'
    for k in "${!check_names[@]}"; do
      IFS='|' read -r result counts seconds <<<"${check_rows[k]}"
      printf '| %s | %s | %s | %s | %s |\n' "${check_names[k]}" "$(what_is "${check_names[k]}")" "$result" "$counts" "$(clock "$seconds")"
    done
    for k in "${waiting[@]}"; do
      rows_of "$k" || true
    done
  } >docs/quality.md.new
  mv docs/quality.md.new docs/quality.md
}

# read_quality: what passed before, from the page as it stands, if it is of this very commit and length.
read_quality() {
  local page=docs/quality.md
  [[ -z $all_changed ]] && grep -qsx -- "\* Commit: $all_commit" "$page" && grep -qs "^\* Lengths: \`--minutes $minutes\`" "$page" || return 0
  all_date=$(sed -n 's/^\* Begun: //p' "$page")
  mapfile -t rows_before < <(grep '^| [a-z]' "$page")
}

# rows_of CHECK: its rows and those of its parts, as the page has them, if it passed before.
rows_of() {
  local rows
  rows=$(printf '%s\n' "${rows_before[@]}" | grep -E "^\| $1(_[^ ]*)? \|") && [[ $rows == *"$1 | "*" | passed | "* ]] && echo "$rows"
}

# take_rows CHECK: its rows, if it passed before.
take_rows() {
  local rows name result counts clock
  rows=$(rows_of "$1") || return 1
  while IFS='|' read -r _ name _ result counts clock _; do
    clock=${clock# } clock=${clock% } counts=${counts# } name=${name# } result=${result# }
    add_row "${name% }" "${result% }" "${counts% }" $((10#${clock%:*} * 60 + 10#${clock#*:}))
  done <<<"$rows"
  printf '%-12s passed before\n' "$1"
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
  # Now, as nobody is there later to type a password.
  need lib test studio demo python package browser mpi fuzz lint bench
  trap 'stop_checks; write_quality "stopped before its end"; echo; print_checks; exit 130' INT TERM
  say "everything, whatever fails; docs/quality.md says what came of it, out/checks what was printed"
  local name rows_before=() waiting=("${all_checks[@]}")
  read_quality
  for name in "${all_checks[@]}"; do
    waiting=("${waiting[@]:1}")
    if take_rows "$name"; then
      :
    elif [[ " ${only[*]} " == *" $name "* ]]; then
      run_check "$name" "all_$name"
      case $name in
        fuzz) add_parts fuzz $((60 * minutes)) ;;
        search) add_parts search $((360 * minutes)) ;;
      esac
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

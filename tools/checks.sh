# For ./dev guard and ./dev all, which read this file: checks run one after the other, and a table of what came of them.
# A check is a function that fails, passes, or returns $skipped with its reason as the last line of what it prints.
# shellcheck shell=bash

skipped=77
check_names=() check_rows=() # the second: result|counts|seconds, and |commit where it is not of this run
checks_failed=0
running='' running_job='' running_since=0

# run_check NAME FUNCTION [ARG...]: what it prints goes into out/checks/NAME.log.
run_check() {
  local name=$1 status=0 result
  shift
  local log="out/checks/$name.log"
  mkdir -p out/checks
  printf '%-12s ' "$name"
  running=$name running_since=$SECONDS
  # A process group of its own, so that all of it can be ended.
  set -m
  (
    set -e
    "$@"
  ) </dev/null >"$log" 2>&1 &
  running_job=$!
  set +m
  wait "$running_job" || status=$?
  running_job=''
  case $status in
    0) result=passed ;;
    "$skipped") result=skipped ;;
    *) result=FAILED checks_failed=$((checks_failed + 1)) ;;
  esac
  add_row "$name" "$result" "$(counts_of "$log")" $((SECONDS - running_since))
  running=''
  printf '%-8s %6s  %s\n' "$result" "$(clock $((SECONDS - running_since)))" "$(counts_of "$log")"
  [[ $result != FAILED ]] || { tail -n 30 "$log" | sed 's/^/    /' && echo "    (all of it: $log)"; }
}

# add_row NAME RESULT COUNTS SECONDS
add_row() {
  check_names+=("$1")
  check_rows+=("$2|${3//|//}|$4")
}

# stop_checks: ends the check that runs, with all that it started.
stop_checks() {
  trap '' INT TERM
  [[ -z $running_job ]] || kill -TERM -- "-$running_job" 2>/dev/null || true
  [[ -z $running ]] || add_row "$running" stopped "$(counts_of "out/checks/$running.log")" $((SECONDS - running_since))
  running=''
}

clock() { printf '%d:%02d' $(($1 / 60)) $(($1 % 60)); }

# counts_of LOG: tests run, inputs tried, cases searched; or else the last line.
counts_of() {
  awk '
    /tests failed out of [0-9]+$/ { ran += $NF; ran_failed += $4 }
    /\*\*\*Skipped/ { ran_skipped++ }
    /^\[  (PASSED|FAILED|SKIPPED)  ?\] [0-9]+ tests?/ { here += $4 }
    /^\[  FAILED  \] [0-9]+ tests?/ { here_failed += $4 }
    /^\[  SKIPPED \] [0-9]+ tests?/ { here_skipped += $4 }
    /^(#|ℹ) tests [0-9]+$/ { page += $3 }
    /^(#|ℹ) fail [0-9]+$/ { page_failed += $3 }
    /^(#|ℹ) skipped [0-9]+$/ { page_skipped += $3 }
    / clean, [0-9]+ inputs$/ { inputs += $(NF - 1); targets++ }
    / clean, [0-9]+ cases, / { cases += $3 }
    / clean, [0-9]+ attacks, / { attacks += $3 }
    /[^[:space:]]/ { last = $0 }
    END {
      if (!ran) { ran = here; ran_failed = here_failed; ran_skipped = here_skipped }  # else a part of what ctest ran
      if (ran + page) {
        printf "%d tests, %d failed, %d skipped", ran + page, ran_failed + page_failed, ran_skipped + page_skipped
      } else if (targets) {
        printf "%d target%s, %d inputs", targets, targets == 1 ? "" : "s", inputs
      } else if (cases + attacks) {
        printf "%d cases, %d attacks on certificates", cases, attacks
      } else {
        gsub(/\033\[[0-9;]*m/, "", last)
        printf "%s", substr(last, 1, 120)
      }
    }' "$1" 2>/dev/null || true
}

# print_checks: the table, for a terminal.
print_checks() {
  local k result counts seconds
  printf '%-12s %-8s %8s  %s\n' check result time counts
  for k in "${!check_names[@]}"; do
    IFS='|' read -r result counts seconds _ <<<"${check_rows[k]}"
    printf '%-12s %-8s %8s  %s\n' "${check_names[k]}" "$result" "$(clock "$seconds")" "$counts"
  done
}

# need_data: where the real motions are, or a reason to skip.
need_data() {
  [[ -d ../shared/data ]] && return 0
  echo "the motions, ../shared/data, are not here"
  return "$skipped"
}

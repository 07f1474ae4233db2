#!/usr/bin/env bash
# The step of action.yml. Runs anywhere: BRDF, SUBJECTS, ARGUMENTS, BASELINE and OUTPUT are its inputs.
set -uo pipefail

BRDF=${BRDF:-brdf}
OUTPUT=${OUTPUT:-brdf-report}
mkdir -p "$OUTPUT"
# Words are split on purpose: the inputs are lists.
read -ra subjects <<<"${SUBJECTS:?}"
read -ra arguments <<<"${ARGUMENTS:-}"
if [ -n "${BASELINE:-}" ] && [ -e "$BASELINE" ]; then
    arguments+=(--baseline "$BASELINE")
fi

"$BRDF" check "${subjects[@]}" "${arguments[@]}" --no-twins --json --figures \
    --junit "$OUTPUT/junit.xml" --html "$OUTPUT/report.html" >"$OUTPUT/report.json"
code=$?

# The table for people, from the same numbers.
if [ -s "$OUTPUT/report.json" ]; then
    "$BRDF" merge "$OUTPUT/report.json" | tee "$OUTPUT/report.txt"
    if [ -n "${GITHUB_STEP_SUMMARY:-}" ]; then
        { echo '```'; cat "$OUTPUT/report.txt"; echo '```'; } >>"$GITHUB_STEP_SUMMARY"
    fi
fi
[ -z "${GITHUB_OUTPUT:-}" ] || echo "exit-code=$code" >>"$GITHUB_OUTPUT"
exit "$code"

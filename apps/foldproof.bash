# Completion of foldproof for bash, from its help texts.
_foldproof() {
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} help words=
  if ((COMP_CWORD == 1)) || [[ $command == help ]]; then
    words=$("$1" --help | sed -n '/^Subcommands:/,/^$/ s/^  \([a-z]*\) .*/\1/p')
    [[ $word != -* ]] || words='--help --version'
  else
    help=$("$1" help "$command" 2>/dev/null)
    if [[ $previous =~ ^--?[a-z-]+$ ]]; then  # the values of "--mode proven|paper"
      words=$(sed -nE "s/^  (-.,)?$previous ([a-z|-]+\|[a-z|-]+)( .*)?$/\2/p" <<<"$help")
    fi
    if [[ -n $words ]]; then
      words=${words//|/ }
    elif [[ $word == -* ]]; then
      words=$(sed -nE 's/^  (-.,)?(--[a-z-]+).*/\2/p' <<<"$help")
    fi
  fi
  COMPREPLY=()
  # Else the name of a file.
  [[ -z $words ]] || COMPREPLY=($(compgen -W "$words" -- "$word"))
}
complete -o default -F _foldproof foldproof

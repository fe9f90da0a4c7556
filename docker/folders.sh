# shellcheck shell=bash
# Sourced by docker/run: which folders of this machine the container sees, each under its own name, so that a path
# means the same in it as outside. Those of paths among the arguments are found here: without them a results folder
# elsewhere would be written in the container, and be lost with it.
# shellcheck disable=SC2154  # root and here are docker/run's, scratch is docker/container.sh's

folders=()

# Whether a path lies in a folder that the container sees already.
is_seen() {
    local folder
    for folder in "${folders[@]}"; do
        case "$1/" in "$folder"/*) return 0 ;; esac
    done
    return 1
}

# The container has such folders of its own: this machine's in their place would break it.
is_system_folder() {
    case "${1%/}/" in
        / | /run/ | /var/ | /var/cache/ | /var/lib/ | /var/log/ | /cache/ | "$scratch"/ | /ncf_fenicsx/) return 0 ;;
        /bin/* | /boot/* | /dev/* | /etc/* | /lib/* | /lib32/* | /lib64/* | /proc/* | /sbin/* | /sys/* | /usr/*) return 0 ;;
        *) return 1 ;;
    esac
}

# Programs and devices under these names are the container's own.
is_of_container() {
    case "$1" in
        /bin[/:]* | /sbin[/:]* | /usr/bin[/:]* | /usr/sbin[/:]* | /usr/local/bin[/:]* | /usr/local/sbin[/:]*) return 0 ;;
        /dev/null | /dev/zero | /dev/full | /dev/tty | /dev/stdin | /dev/stdout | /dev/stderr) return 0 ;;
        *) return 1 ;;
    esac
}

# show PATH [WHAT]: let the container see it; of a file, or of what is yet to be made, the nearest folder that exists.
show() {
    local folder=$1
    if is_seen "$1" || is_of_container "$1"; then return; fi
    until [ -d "$folder" ]; do folder=$(dirname "$folder"); done
    if is_system_folder "$folder"; then
        fail "${2:-}$1: the container has a $folder of its own, as of all folders of the system, and does not see this" \
            "machine's; take a path in a folder of yours that exists, or in /tmp"
    fi
    case "$folder" in *:*) fail "${2:-}$folder: the container cannot share a folder with a colon in its name" ;; esac
    folders+=("$folder")
}

# Each argument, and what stands behind an =, is taken for a path: most lie in the working folder, and nothing is done.
# Both ends of a link are shown. A program's text is left alone: the word after -c, as in bash -c and python3 -c.
show_arguments() {
    local word path before=
    for word in "$@"; do
        if [ "$before" = -c ]; then before=; continue; fi
        before=$word
        while true; do
            path=${word#[\"\']}; path=${path%[\"\']}
            case "$path" in
                "" | -*) ;;
                *)  if path=$(realpath --canonicalize-missing --no-symlinks -- "$path" 2>/dev/null); then
                        show "$path"
                        is_of_container "$path" || show "$(realpath --canonicalize-missing -- "$path")"
                    fi ;;
            esac
            case "$word" in *=*) word=${word#*=} ;; *) break ;; esac
        done
    done
}

# All that the command given as arguments is to see.
choose_folders() {
    local folder
    folders=("$root")
    for folder in /tmp /var/tmp; do
        if [ -d "$folder" ]; then folders+=("$folder"); fi
    done
    show "$here" "working folder "
    show_arguments results "$@"  # results go to results/NAME unless the arguments say so, and that may be a link
}

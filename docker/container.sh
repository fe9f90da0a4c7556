# shellcheck shell=bash
# Sourced by docker/run: how a command runs in the image by Docker or podman, once it is known with which folders.
# shellcheck disable=SC2154  # root, here, engine, image, files are docker/run's; folders are docker/folders.sh's

scratch=/ncf_scratch

# Where compiled forms and the log of the build stay between calls: $cache. Files are written as the owner of the
# checkout, so root has one for each owner.
choose_cache() {
    local name=ncf-fenicsx
    owner=$(stat -c %u "$root"); group=$(stat -c %g "$root")
    if [ "$(id -u)" = 0 ] && [ "$owner" != 0 ]; then name+="-$owner"; fi
    if [ -z "${HOME:-}" ]; then unset HOME; export HOME=~; fi  # from the system's list of users then
    cache=$(realpath --canonicalize-missing "${XDG_CACHE_HOME:-$HOME/.cache}/$name")
    case "$cache" in *:*) fail "$cache: the container cannot share a folder with a colon in its name; set XDG_CACHE_HOME" ;; esac
    mkdir -p "$cache" 2>/dev/null || fail "$cache cannot be made; set XDG_CACHE_HOME to a folder of your own"
    if [ "$(id -u)" = 0 ]; then chown "$owner:$group" "$cache"; fi
}

run_in_container() {
    local options folder name
    # Programs put their own temporary files in memory, not in /tmp: two containers would mistake each other's there.
    # The home is read-only like the rest, so matplotlib needs a folder for its settings.
    options=(--rm --interactive --network host --shm-size 1g --workdir "$here"
        --read-only --tmpfs "$scratch:rw,exec,mode=1777" --env "TMPDIR=$scratch"
        --env HOME=/ --env MPLCONFIGDIR=/cache/matplotlib
        --volume "$root:/ncf_fenicsx" --volume "$cache:/cache")
    for folder in "${folders[@]}"; do options+=(--volume "$folder:$folder"); done
    for name in OMP_NUM_THREADS OPENBLAS_NUM_THREADS CI; do
        if [ -n "${!name:-}" ]; then options+=(--env "$name"); fi
    done
    if [ -t 0 ] && [ -t 1 ]; then options+=(--tty --env "TERM=${TERM:-xterm}"); fi
    choose_user
    exec "${engine[@]}" run "${options[@]}" "$image" "$@"
}

# The owner of the checkout is the user of the image inside, where podman can map it.
choose_user() {
    local most
    if [ "${engine[0]}" = docker ]; then
        options+=(--user "$owner:$group")
        if [ "$owner" = 0 ]; then options+=(--env OMPI_ALLOW_RUN_AS_ROOT=1 --env OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1); fi
        return
    fi
    # no more than this machine allows: podman asks for more by itself, and fails where it is root in a container
    most=$(ulimit -Hu); if [ "$most" = unlimited ] || [ "$most" -gt 8192 ]; then most=8192; fi
    options+=(--ulimit "nofile=$files" --ulimit "nproc=$most:$most")
    if [ "$(id -u)" != 0 ]; then
        options+=(--userns "keep-id:uid=1000,gid=1000" --user 1000:1000)
    elif [ "$owner" = 0 ]; then
        options+=(--uidmap 1000:0:1 --uidmap 0:1:1000 --gidmap 1000:0:1 --gidmap 0:1:1000 --user 1000:1000)
    else
        options+=(--user "$owner:$group")
    fi
}

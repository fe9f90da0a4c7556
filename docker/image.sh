# shellcheck shell=bash
# Sourced by docker/run: the name of the project's image, and how to build it where it is not here yet.
# shellcheck disable=SC2154  # root, cache, engine, image and files are docker/run's

# choose_dolfinx [VERSION]: the first of packages.txt unless one is asked for; and Debian's release that has it.
choose_dolfinx() {
    local versions releases place
    read -ra versions <<<"$(awk '$1 == "dolfinx"' "$root/docker/packages.txt")"
    read -ra releases <<<"$(awk '$1 == "debian"' "$root/docker/packages.txt")"
    for place in "${!versions[@]}"; do
        if [ "$place" -gt 0 ] && [ "${versions[place]}" = "${1-${versions[1]}}" ]; then
            dolfinx=${versions[place]} release=${releases[place]}
            return
        fi
    done
    fail "--dolfinx $1: expected one of ${versions[*]:1}"
}

# The image is known by what it is made from: with another Dockerfile, other dependencies or another way to build it,
# it is another image. How pyproject.toml sets the tools that check the project makes no difference.
image_name() {
    local recipe
    recipe=$(
        { printf '%s\n' "$dolfinx"
          cat "$root/docker/Dockerfile" "$root/docker/packages.txt" "$root/docker/image.sh"
          awk '/^\[/ { made_from = !/^\[+tool\./ || /^\[+tool\.setuptools/ } made_from' "$root/pyproject.toml"
        } | sha256sum
    )
    printf 'localhost/ncf-fenicsx:%s' "${recipe:0:12}"
}

has_image() { "${engine[@]}" image inspect "$1" >/dev/null 2>&1; }

install_mmdebstrap() {
    command -v mmdebstrap >/dev/null && return
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null && apt-get install --yes mmdebstrap >/dev/null 2>&1
}

# Name of a plain Debian to start from: the one of the registry, or where none answers one made of Debian's packages.
base_image() {
    local wanted=docker.io/library/debian:$release-slim made=localhost/ncf-fenicsx-base:$release archive
    if has_image "$made"; then printf '%s' "$made"; return; fi
    if timeout 120 "${engine[@]}" pull --quiet "$wanted" >/dev/null 2>&1; then printf '%s' "$wanted"; return; fi
    install_mmdebstrap || fail "$wanted cannot be pulled, and mmdebstrap is not here to make it from Debian's packages"
    say "$wanted cannot be pulled; making it from Debian's packages with mmdebstrap"
    archive=$(mktemp --suffix=.tar)
    # an index of unstable may be older than it says it lasts
    mmdebstrap --quiet --variant=minbase --aptopt='Acquire::Check-Valid-Until "false"' "$release" "$archive" >&2 \
        || fail "mmdebstrap failed; are Debian's package servers reachable?"
    "${engine[@]}" import "$archive" "$made" >/dev/null 2>&1 || fail "the base image made by mmdebstrap cannot be imported"
    rm -f "$archive"
    printf '%s' "$made"
}

build_image() {
    local base log="$cache/build.log" context options
    base=$(base_image) || exit 1
    say "building the image $image with DOLFINx $dolfinx, about five minutes (once); details in $log"
    # not the whole checkout: results in it may be large
    context=$(mktemp -d)
    cp -r "$root/pyproject.toml" "$root/README.md" "$root/LICENSE" "$root/ncf_fenicsx" "$context"
    mkdir "$context/docker" && cp "$root/docker/packages.txt" "$context/docker"
    options=(--network host --tag "$image" --file "$root/docker/Dockerfile"
        --build-arg "BASE=$base" --build-arg "DOLFINX=$dolfinx")
    # a network with a certificate authority of its own: pip needs to know it
    if [ -s /etc/ssl/certs/ca-certificates.crt ]; then
        options+=(--secret "id=certificates,src=/etc/ssl/certs/ca-certificates.crt")
    fi
    # chroot: the other kinds of isolation need rights that root in a container lacks
    if [ "${engine[0]}" = podman ]; then options+=(--isolation chroot --ulimit "nofile=$files"); fi
    "${engine[@]}" build "${options[@]}" "$context" >"$log" 2>&1 \
        || fail "the build failed: $(grep -iE 'error|^E:' "$log" | tail -n 1) (all of it in $log)"
    rm -rf "$context"
}

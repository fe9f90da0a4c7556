# shellcheck shell=bash
# Sourced by docker/run: the name of the project's image, and how to build it where it is not here yet.
# shellcheck disable=SC2154  # root, cache, engine, image and files are docker/run's

# The image is known by what it is made from: with another Dockerfile, other dependencies or another way to build it,
# it is another image. How pyproject.toml sets the tools that check the project makes no difference.
image_name() {
    local recipe
    recipe=$(
        { cat "$root/docker/Dockerfile" "$root/docker/image.sh"
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
    local wanted=docker.io/library/debian:trixie-slim made=localhost/ncf-fenicsx-base:trixie archive
    if has_image "$made"; then printf '%s' "$made"; return; fi
    if timeout 120 "${engine[@]}" pull --quiet "$wanted" >/dev/null 2>&1; then printf '%s' "$wanted"; return; fi
    install_mmdebstrap || fail "$wanted cannot be pulled, and mmdebstrap is not here to make it from Debian's packages"
    say "$wanted cannot be pulled; making it from Debian's packages with mmdebstrap"
    archive=$(mktemp --suffix=.tar)
    mmdebstrap --quiet --variant=minbase trixie "$archive" >&2 || fail "mmdebstrap failed; are Debian's package servers reachable?"
    "${engine[@]}" import "$archive" "$made" >/dev/null 2>&1 || fail "the base image made by mmdebstrap cannot be imported"
    rm -f "$archive"
    printf '%s' "$made"
}

build_image() {
    local base log="$cache/build.log" context options
    base=$(base_image) || exit 1
    say "building the image $image, about five minutes (once); details in $log"
    # not the whole checkout: results in it may be large
    context=$(mktemp -d)
    cp -r "$root/pyproject.toml" "$root/README.md" "$root/LICENSE" "$root/ncf_fenicsx" "$context"
    options=(--network host --tag "$image" --build-arg "BASE=$base" --file "$root/docker/Dockerfile")
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
